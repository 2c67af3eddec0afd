// Synthesised against captured clips as sets: Fréchet distance, diversity, classifier. METHODS section 6.

#include <algorithm>
#include <array>
#include <boost/random/uniform_int_distribution.hpp>
#include <cstdio>
#include <numeric>
#include <random>

#include "api/study/sample_sets.h"
#include "api/study/sample_study.h"
#include "datasets/error_reason.h"
#include "datasets/parallel_for.h"
#include "synthesis/clip_ends.h"
#include "synthesis/evaluation.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/frechet_distance.h"
#include "synthesis/pose_windows.h"
#include "synthesis/window_classifier.h"
#include "synthesis/window_space.h"

namespace morphograph {
namespace {

using Json = nlohmann::ordered_json;
using Form = ChartSeries::Form;

constexpr std::uint64_t kTellingStream = 0x9e3779b97f4a7c15ull;  // seeds of halvings lie so far apart
constexpr Eigen::Index kFewestWindows = 64;  // two a direction of the WindowSpace

// Windows of each clip.
std::vector<Eigen::MatrixXd> WindowsOf(const std::vector<MotionClip>& clips, int jobs) {
  std::vector<Eigen::MatrixXd> windows(clips.size());
  ParallelFor(jobs, static_cast<int>(clips.size()),
              [&](int i) { windows[static_cast<size_t>(i)] = PoseWindows(PrepareEvaluation(clips[static_cast<size_t>(i)])); });
  return windows;
}

// Classes of figures of one way to cut the captured clips.
struct Cut {
  std::string name;   // "clips as they are"
  std::string id;     // in the data
  bool trimmed = false;
  int halvings = 1;
};

// How well clips made of one half of the captured ones are told from the other half.
struct HalfDistinction {
  std::vector<double> areas;  // under the curve, a value a halving; mean of both ways
  double floor = 0;

  double auc() const { return std::accumulate(areas.begin(), areas.end(), 0.0) / static_cast<double>(areas.size()); }
  double difference() const { return auc() - floor; }
};

struct StyleLikeness {
  std::optional<double> frechet_ratio, diversity_ratio;       // trained on all
  std::optional<double> halves_distance;                      // of random halves of the captured clips, mean
  std::optional<double> half_frechet_ratio;                   // trained on one half, judged on the other
  std::optional<WindowDistinction> told;                      // trained on all
  std::optional<HalfDistinction> half_told, copies_told;      // clips of models of one half, and of that half itself, judged on the other
  std::string note;
};

std::vector<MotionClip> CutClips(const std::vector<MotionClip>& clips, const Cut& cut) {
  if (cut.trimmed) return WithoutEnds(clips);
  std::vector<MotionClip> long_enough;  // to hold a window
  for (const MotionClip& clip : clips) {
    if (clip.frame_count() >= PoseWindowOptions().frames) long_enough.push_back(clip);
  }
  return long_enough;
}

// Folds of the classifier: five, fewer where halves hold fewer clips; 0 where even two cannot be filled.
int FoldsFor(size_t clips_of_half) { return clips_of_half < 2 ? 0 : static_cast<int>(std::min<size_t>(5, clips_of_half)); }

WindowClassifierOptions ClassifierOptions(const StudyOptions& options, int halvings, int folds) {
  return {.trees = options.quick ? 40 : 200, .folds = folds, .halvings = options.quick ? 1 : halvings, .seed = options.seed, .jobs = options.jobs};
}

void JudgeWhole(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured, bool classify, const Cut& cut,
                const StudyOptions& options, StyleLikeness* likeness) {
  try {
    const SetComparison compared =
        CompareWindowSets(WindowsOf(synthesised, options.jobs), WindowsOf(captured, options.jobs), options.seed);
    likeness->frechet_ratio = compared.frechet_ratio;
    likeness->halves_distance = compared.frechet_halves;
    likeness->diversity_ratio = compared.diversity / compared.diversity_reference;
  } catch (const std::invalid_argument& unfit) {
    likeness->note = ReasonOf(unfit);
  }
  const int folds = FoldsFor(captured.size() / 2);
  if (classify && folds > 0) likeness->told = TellApart(synthesised, captured, ClassifierOptions(options, cut.halvings, folds));
}

// The two halves of the captured clips, and what models of each have synthesised.
struct Halves {
  std::vector<MotionClip> synthesised[2], captured[2];

  bool drawn() const { return !synthesised[0].empty() && !synthesised[1].empty(); }
};

// Fréchet distance of what a model of one half synthesises to the other half, mean of both ways, in the space of all captured windows.
std::optional<double> HalfFrechet(const Halves& halves, int jobs) {
  std::vector<Eigen::MatrixXd> captured[2];
  for (int h = 0; h < 2; ++h) captured[h] = WindowsOf(halves.captured[h], jobs);
  if (captured[0].empty() || captured[1].empty() || !halves.drawn()) return std::nullopt;
  const Eigen::MatrixXd joined[2] = {JoinColumns(captured[0]), JoinColumns(captured[1])};
  if (joined[0].cols() < kFewestWindows || joined[1].cols() < kFewestWindows) return std::nullopt;
  const WindowSpace space(JoinColumns({joined[0], joined[1]}));
  const GaussianFit fits[2] = {FitGaussian(space.Project(joined[0])), FitGaussian(space.Project(joined[1]))};
  double sum = 0;
  for (int h = 0; h < 2; ++h) {
    const Eigen::MatrixXd drawn = JoinColumns(WindowsOf(halves.synthesised[h], jobs));
    sum += FrechetDistance(FitGaussian(space.Project(drawn)), fits[1 - h]) / 2;
  }
  return sum;
}

// As many of the clips as are synthesised, each drawn from all of them: what a model that knew its half by heart would make.
std::vector<MotionClip> Copies(const std::vector<MotionClip>& clips, size_t count, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  boost::random::uniform_int_distribution<size_t> any(0, clips.size() - 1);
  std::vector<MotionClip> copies;
  for (size_t i = 0; i < count; ++i) copies.push_back(clips[any(rng)]);
  return copies;
}

// How well what models of halves synthesise, and copies of these halves' own clips, are told from the other halves; both ways. The floor is that of
// the random halves of the model of all clips: these few alone say little, and with few clips what sets one half apart in a fold is what it lacks in the others.
void TellHalves(const std::vector<Halves>& halvings, int style, const StudyOptions& options, StyleLikeness* likeness) {
  struct Task {
    const std::vector<MotionClip>* all;
    std::vector<MotionClip> drawn;
    ClipHalves halving;
    WindowClassifierOptions classifier;
  };
  std::vector<std::vector<MotionClip>> captured(halvings.size());
  std::vector<Task> tasks;  // a halving: model and copies of the first half, model and copies of the second
  for (size_t n = 0; n < halvings.size(); ++n) {
    const Halves& halves = halvings[n];
    const int folds = FoldsFor(std::min(halves.captured[0].size(), halves.captured[1].size()));
    if (folds == 0 || !halves.drawn()) continue;
    captured[n] = halves.captured[0];
    captured[n].insert(captured[n].end(), halves.captured[1].begin(), halves.captured[1].end());
    std::vector<int> sides[2];
    for (size_t i = 0; i < captured[n].size(); ++i) sides[i < halves.captured[0].size() ? 0 : 1].push_back(static_cast<int>(i));
    WindowClassifierOptions classifier = ClassifierOptions(options, 1, folds);
    classifier.seed += kTellingStream * (2 * n + 1);
    classifier.jobs = 1;
    for (int h = 0; h < 2; ++h) {
      const ClipHalves halving{sides[h], sides[1 - h]};
      tasks.push_back({&captured[n], halves.synthesised[h], halving, classifier});
      tasks.push_back({&captured[n], Copies(halves.captured[h], halves.synthesised[h].size(), classifier.seed + static_cast<std::uint64_t>(2 * style + h)), halving, classifier});
    }
  }
  if (tasks.empty()) return;
  std::vector<double> areas(tasks.size());
  ParallelFor(options.jobs, static_cast<int>(tasks.size()), [&](int i) {
    const Task& task = tasks[static_cast<size_t>(i)];
    areas[static_cast<size_t>(i)] = AreaAgainstHalf(task.drawn, *task.all, task.halving, task.classifier);
  });
  likeness->half_told = likeness->copies_told = HalfDistinction{{}, likeness->told->floor};
  for (size_t i = 0; i < areas.size(); i += 4) {
    likeness->half_told->areas.push_back((areas[i] + areas[i + 2]) / 2);
    likeness->copies_told->areas.push_back((areas[i + 1] + areas[i + 3]) / 2);
  }
}

// Mean over the halvings; distances over that between random halves, as these few vary by a factor of three from one to the next. Told apart where it is a style's, by its number.
void JudgeHalves(const std::vector<Halves>& halvings, std::optional<int> style, const StudyOptions& options, StyleLikeness* likeness) {
  double sum = 0;
  int measured = 0;
  for (const Halves& halves : halvings) {
    if (const std::optional<double> distance = HalfFrechet(halves, options.jobs)) sum += *distance, ++measured;
  }
  if (measured > 0 && likeness->halves_distance) likeness->half_frechet_ratio = sum / measured / *likeness->halves_distance;
  if (style && likeness->told) TellHalves(halvings, *style, options, likeness);
}

Json ToldJson(const std::optional<WindowDistinction>& told) {
  if (!told) return nullptr;
  return {{"auc", told->auc}, {"floor", told->floor}, {"above_floor", told->difference}, {"standard_error", told->standard_error}, {"windows", told->windows}};
}

Json ToldJson(const std::optional<HalfDistinction>& told) {
  if (!told) return nullptr;
  return {{"auc", told->auc()}, {"floor", told->floor}, {"above_floor", told->difference()}, {"auc_of_halvings", told->areas}};
}

Json LikenessJson(const StyleLikeness& likeness) {
  Json json = {{"frechet_ratio", OrNull(likeness.frechet_ratio)},
               {"diversity_ratio", OrNull(likeness.diversity_ratio)},
               {"classifier", ToldJson(likeness.told)},
               {"trained_on_one_half", {{"frechet_ratio", OrNull(likeness.half_frechet_ratio)}, {"classifier", ToldJson(likeness.half_told)}}},
               {"copies_of_one_half", {{"classifier", ToldJson(likeness.copies_told)}}}};
  if (!likeness.note.empty()) json["note"] = likeness.note;
  return json;
}

using ByName = std::vector<std::pair<std::string, StyleLikeness>>;

// The greatest, or least, over the styles, and whose it is.
struct Extreme {
  std::optional<double> value;
  std::string style;
};
template <typename Get>
Extreme WorstOf(const ByName& styles, Get get, bool greatest = true) {
  Extreme worst;
  for (const auto& [style, likeness] : styles) {
    const std::optional<double> value = get(likeness);
    if (value && (!worst.value || (greatest ? *value > *worst.value : *value < *worst.value))) worst = {value, style};
  }
  return worst;
}

std::optional<double> DifferenceOf(const std::optional<HalfDistinction>& told) { return told ? std::optional(told->difference()) : std::nullopt; }

template <typename... Values>
std::string Printed(const char* format, Values... values) {
  char text[120];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string Too(const std::optional<double>& value, const std::string& otherwise) {
  return value ? otherwise : "too few clips or windows to tell";
}

void AddFigures(const Cut& cut, const StyleLikeness& overall, const ByName& styles, StudySection* section) {
  const auto add = [&](const std::string& what, const std::optional<double>& value, std::optional<double> at_least, std::optional<double> at_most,
                       const std::string& note) {
    section->figures.push_back({what + "; " + cut.name, value, "", std::nullopt, "", at_least, at_most, Too(value, note)});
  };
  const auto named = [](const Extreme& worst, const std::string& more) {
    return "style " + StyleLabel(worst.style) + (more.empty() ? "" : "; " + more);
  };
  const auto areas_of = [&](const std::string& style, auto say) {
    for (const auto& [name, likeness] : styles)
      if (name == style) return say(likeness);
    return std::string();
  };
  const auto all_of = [](const StyleLikeness& likeness) {
    if (!likeness.told) return std::string();
    const std::string said = Printed("area %.3f, floor %.3f", likeness.told->auc, likeness.told->floor);
    const double error = likeness.told->standard_error;  // 0: of a single halving
    return error > 0 ? said + Printed(", standard error over halves %.3f", error) : said;
  };
  const auto halves_of = [](const std::optional<HalfDistinction>& told) {
    if (!told) return std::string();
    std::string said = Printed("area %.3f, floor %.3f", told->auc(), told->floor);
    if (told->areas.size() > 1) {
      said += "; halvings";
      for (const double area : told->areas) said += Printed(" %.3f", area);
    }
    return said;
  };
  add("Fréchet distance over that of captured halves", overall.frechet_ratio, std::nullopt, 1.0, "all styles together");
  Extreme worst = WorstOf(styles, [](const StyleLikeness& s) { return s.frechet_ratio; });
  add("the same, worst style", worst.value, std::nullopt, 1.3, named(worst, ""));
  add("Fréchet distance, trained on one half and judged on the other", overall.half_frechet_ratio, std::nullopt, 1.3,
      "all styles together; over the mean distance of random halves");
  worst = WorstOf(styles, [](const StyleLikeness& s) { return s.half_frechet_ratio; });
  add("the same, worst style", worst.value, std::nullopt, 1.6, named(worst, ""));
  worst = WorstOf(styles, [](const StyleLikeness& s) { return s.told ? std::optional(s.told->difference) : std::nullopt; });
  add("classifier's area under the curve above its floor, worst style", worst.value, std::nullopt, 0.05,
      named(worst, areas_of(worst.style, all_of)));
  worst = WorstOf(styles, [](const StyleLikeness& s) { return DifferenceOf(s.half_told); });
  add("the same, trained on one half and judged on the other, worst style", worst.value, std::nullopt, 0.10,
      named(worst, areas_of(worst.style, [&](const StyleLikeness& s) { return halves_of(s.half_told); })));
  worst = WorstOf(styles, [](const StyleLikeness& s) { return DifferenceOf(s.copies_told); });
  add("the same for captured clips of the learned half, drawn with repetition, worst style", worst.value, std::nullopt, std::nullopt,
      named(worst, areas_of(worst.style, [&](const StyleLikeness& s) { return halves_of(s.copies_told); })));
  worst = WorstOf(styles, [](const StyleLikeness& s) {
    return s.half_told && s.copies_told ? std::optional(s.half_told->auc() - s.copies_told->auc()) : std::nullopt;
  });
  add("area of models of one half above that of these captured clips, worst style", worst.value, std::nullopt, std::nullopt, named(worst, ""));
  const auto diversity = [](const StyleLikeness& s) { return s.diversity_ratio; };
  worst = WorstOf(styles, diversity, false);
  add("diversity of one style's clips / captured, least", worst.value, 0.9, 1.1, named(worst, ""));
  worst = WorstOf(styles, diversity, true);
  add("diversity of one style's clips / captured, greatest", worst.value, 0.9, 1.1, named(worst, ""));
}

// Halves of the clips, and what a model of each has synthesised.
struct LearnedHalves {
  StudyContext::Halves clips;
  StyledClips synthesised[2];
};

ChartSeries Bars(const std::string& name) { return {.name = name, .x = {}, .y = {}, .form = Form::kBars}; }

void AddCharts(const Cut& cut, const StyleLikeness& overall, const ByName& styles, StudySection* section) {
  Chart frechet{.title = "Fréchet distance, " + cut.name, .x_label = "style", .y_label = "ratio to captured halves", .better = "lower"};
  frechet.caption = "Distance of synthesised from captured windows over that between halves of the captured clips: 1 is as near as another half.";
  frechet.series = {Bars("trained on all"), Bars("trained on one half, judged on the other")};
  frechet.marks = {{"captured halves", 1}};
  Chart told{.title = "Classifier, " + cut.name, .x_label = "style", .y_label = "area under the curve", .better = "lower"};
  told.caption = "How well a random forest tells synthesised from captured windows. Its floor is how well it tells captured from captured; 0.5 is chance.";
  told.series = {Bars("trained on all"), Bars("trained on one half, judged on the other"),
                 Bars("that half's own clips, drawn with repetition"), Bars("floor")};
  told.marks = {{"chance", 0.5}};
  Chart diversity{.title = "Diversity, " + cut.name, .x_label = "style", .y_label = "synthesised / captured"};
  diversity.caption = "Mean distance between windows of a set, synthesised over captured: 1 is as diverse as captured.";
  diversity.series = {Bars("trained on all")};
  diversity.marks = {{"as captured", 1}};
  const auto put = [](const std::optional<double>& y, size_t x, ChartSeries* series) {
    if (y) series->x.push_back(static_cast<double>(x)), series->y.push_back(*y);
  };
  const auto area = [](const std::optional<WindowDistinction>& d) { return d ? std::optional(d->auc) : std::nullopt; };
  const auto half_area = [](const std::optional<HalfDistinction>& d) { return d ? std::optional(d->auc()) : std::nullopt; };
  const auto floor = [](const std::optional<WindowDistinction>& d) { return d ? std::optional(d->floor) : std::nullopt; };
  for (size_t i = 0; i < styles.size(); ++i) {
    const auto& [style, likeness] = styles[i];
    for (Chart* chart : {&frechet, &told, &diversity}) chart->x_names.push_back(StyleLabel(style));
    put(likeness.frechet_ratio, i, &frechet.series[0]);
    put(likeness.half_frechet_ratio, i, &frechet.series[1]);
    put(area(likeness.told), i, &told.series[0]);
    put(half_area(likeness.half_told), i, &told.series[1]);
    put(half_area(likeness.copies_told), i, &told.series[2]);
    put(floor(likeness.told), i, &told.series[3]);
    put(likeness.diversity_ratio, i, &diversity.series[0]);
  }
  if (styles.size() > 1) {
    frechet.x_names.push_back("all together");
    put(overall.frechet_ratio, styles.size(), &frechet.series[0]);
    put(overall.half_frechet_ratio, styles.size(), &frechet.series[1]);
  }
  for (Chart* chart : {&frechet, &told, &diversity}) section->drawings.push_back(std::move(*chart));
}

}  // namespace

StudySection StudyLikeness(StudyContext& context) {
  const StudyOptions& options = context.options();
  const std::vector<MotionClip> captured = AtEvaluationRate(context.clips(StudyData::kClean), options.jobs);
  StudySection section{.id = "likeness", .title = "Likeness of synthesised and captured clips"};
  const int halvings = options.quick ? 1 : 2;  // that models are learned from
  section.text =
      "Clips are cut into windows of half a second: 14 joints relative to the hips, and the hips' speed. The Fréchet distance compares mean and "
      "covariance of two sets of windows in the 32 directions in which captured ones vary most; it is given over the distance between halves of the "
      "captured clips. The classifier is a random forest of 200 trees, cross-validated by clip, on windows with 1 mm of noise on every joint. How "
      "well it tells synthesised from captured windows is given with its floor: how well it tells one half of the captured clips from the other, "
      "with as many windows from clips of the same lengths.\n\nEverything is done twice: with a model of all clips, and with models of one half of "
      "the clips, each judged on the half that it has not seen (mean of both ways). Their distances and floors are those of "
      "random halves, the same as for the model of all clips, as few halvings alone say little: not of the very halves that were learned "
      "from. Whatever a model draws from half of the clips comes from the same few recordings over and over, so that a classifier can learn "
      "these from some of its clips and know them again in others; captured clips of the floor are each there once. What that can make is "
      "shown by the half's own captured clips, drawn with repetition and cut like the model's, as far as they are long enough.\n\nClips are taken as they are, and, where they are long enough, "
      "without their first and last second: recordings set off and slow down there, and synthesised clips are cut out of a walk.";
  const int count = options.quick ? 8 : 100;
  const auto tell = [&](const std::string& stage, double fraction) {
    if (options.progress) options.progress(stage, fraction);
  };
  std::vector<std::string> missing;
  tell("drawing clips", 0);
  const StyledClips synthesised = DrawStyles(*context.Model(StudyData::kClean), {.clips = count, .seed = options.seed, .jobs = options.jobs}, &missing);
  std::vector<LearnedHalves> learned;
  std::string no_halves;
  for (int n = 0; n < halvings && no_halves.empty(); ++n) {
    LearnedHalves halves{context.Halving(n), {}};
    try {
      for (int h = 0; h < 2; ++h) {
        tell("learning from half of the clips", 0.05 + 0.1 * (2 * n + h) / halvings);
        const std::vector<int>& half = halves.clips[static_cast<size_t>(h)];
        halves.synthesised[h] = DrawStyles(*context.Learn(StudyData::kClean, half), {.clips = count, .seed = options.seed, .jobs = options.jobs});
      }
      learned.push_back(std::move(halves));
    } catch (const std::runtime_error& unfit) {  // half of few clips can be too few to learn from
      no_halves = unfit.what();
    }
  }
  if (learned.size() > 1) section.text += "\n\nHalved " + std::to_string(learned.size()) + " times, means are given.";
  if (!no_halves.empty()) {
    section.text += (learned.empty() ? "\n\nHalf of these clips are too few to learn from: " : "\n\nHalved otherwise, these clips were too few to learn from: ") + no_halves;
  }
  for (const std::string& style : missing) section.text += "\n\nThe model cannot walk in style " + StyleLabel(style) + ": too few steps.";

  const std::vector<Cut> cuts = {{"clips as they are", "whole", false, 12}, {"a second off both ends", "trimmed", true, 12}};
  for (size_t c = 0; c < cuts.size(); ++c) {
    const Cut& cut = cuts[c];
    const std::vector<MotionClip> clips = CutClips(captured, cut);
    if (clips.size() < 4) {
      section.text += "\n\nToo few clips are long enough to take a second off both ends.";
      section.data[cut.id] = nullptr;
      continue;
    }
    const StyledClips by_style = ByStyle(clips);
    std::vector<std::array<StyledClips, 2>> by_half;  // of every halving
    for (const LearnedHalves& halves : learned) {
      by_half.push_back({ByStyle(CutClips(Chosen(captured, halves.clips[0]), cut)), ByStyle(CutClips(Chosen(captured, halves.clips[1]), cut))});
    }
    const auto of = [](const StyledClips& set, const std::string& style) {
      const auto at = set.find(style);
      return at == set.end() ? std::vector<MotionClip>() : at->second;
    };
    ByName styles;
    for (const auto& [style, drawn] : synthesised) {
      tell("comparing " + StyleLabel(style), 0.25 + 0.75 * (static_cast<double>(c) + static_cast<double>(styles.size()) / static_cast<double>(synthesised.size())) / static_cast<double>(cuts.size()));
      StyleLikeness likeness;
      const std::vector<MotionClip> own = of(by_style, style);
      JudgeWhole(drawn, own, true, cut, options, &likeness);
      std::vector<Halves> of_style;
      for (size_t n = 0; n < learned.size(); ++n) {
        const auto& [first, second] = learned[n].synthesised;
        of_style.push_back({{of(first, style), of(second, style)}, {of(by_half[n][0], style), of(by_half[n][1], style)}});
      }
      JudgeHalves(of_style, static_cast<int>(styles.size()), options, &likeness);
      section.data[cut.id]["styles"][StyleLabel(style)] = LikenessJson(likeness);
      styles.emplace_back(style, likeness);
    }
    StyleLikeness overall;
    if (styles.size() == 1) {
      overall = styles.front().second;
    } else {
      JudgeWhole(InProportion(synthesised, by_style), clips, false, cut, options, &overall);
      std::vector<Halves> of_all;
      for (size_t n = 0; n < learned.size(); ++n) {
        const auto& [first, second] = learned[n].synthesised;
        of_all.push_back({{InProportion(first, by_half[n][0]), InProportion(second, by_half[n][1])}, {Joined(by_half[n][0]), Joined(by_half[n][1])}});
      }
      JudgeHalves(of_all, std::nullopt, options, &overall);
    }
    section.data[cut.id]["all_styles_together"] = LikenessJson(overall);
    AddFigures(cut, overall, styles, &section);
    AddCharts(cut, overall, styles, &section);
  }
  return section;
}

}  // namespace morphograph
