#include "api/study/likeness_figures.h"

#include <cstdio>

#include "api/study/sample_sets.h"

namespace morphograph {
namespace {

using Json = nlohmann::ordered_json;
using Form = ChartSeries::Form;

Json ToldJson(const std::optional<WindowDistinction>& told) {
  if (!told) return nullptr;
  return {{"auc", told->auc}, {"floor", told->floor}, {"above_floor", told->difference}, {"standard_error", told->standard_error}, {"windows", told->windows}};
}

Json ToldJson(const std::optional<HalfDistinction>& told) {
  if (!told) return nullptr;
  return {{"auc", told->auc()}, {"floor", told->floor}, {"above_floor", told->difference()}, {"auc_of_halvings", told->areas}};
}

// The greatest, or least, over the styles, and whose it is.
struct Extreme {
  std::optional<double> value;
  std::string style;
};
template <typename Get>
Extreme WorstOf(const LikenessByStyle& styles, Get get, bool greatest = true) {
  Extreme worst;
  for (const auto& [style, likeness] : styles) {
    const std::optional<double> value = get(likeness);
    if (value && (!worst.value || (greatest ? *value > *worst.value : *value < *worst.value))) worst = {value, style};
  }
  return worst;
}

std::optional<double> DifferenceOf(const std::optional<WindowDistinction>& told) { return told ? std::optional(told->difference) : std::nullopt; }
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

ChartSeries Bars(const std::string& name) { return {.name = name, .x = {}, .y = {}, .form = Form::kBars}; }

}  // namespace

nlohmann::ordered_json LikenessJson(const Likeness& likeness) {
  Json json = {{"frechet_ratio", OrNull(likeness.frechet_ratio)},
               {"diversity_ratio", OrNull(likeness.diversity_ratio)},
               {"classifier", ToldJson(likeness.told)},
               {"with_recorded_bones", {{"classifier", ToldJson(likeness.told_by_bones)}}},
               {"trained_on_one_half", {{"frechet_ratio", OrNull(likeness.half_frechet_ratio)}, {"classifier", ToldJson(likeness.half_told)}}},
               {"copies_of_one_half", {{"classifier", ToldJson(likeness.copies_told)}}}};
  if (!likeness.note.empty()) json["note"] = likeness.note;
  return json;
}

void AddLikenessFigures(const LikenessCut& cut, const Likeness& overall, const LikenessByStyle& styles, StudySection* section) {
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
  const auto all_of = [](const std::optional<WindowDistinction>& told) {
    if (!told) return std::string();
    const std::string said = Printed("area %.3f, floor %.3f", told->auc, told->floor);
    const double error = told->standard_error;  // 0: of a single halving
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
  Extreme worst = WorstOf(styles, [](const Likeness& s) { return s.frechet_ratio; });
  add("the same, worst style", worst.value, std::nullopt, 1.3, named(worst, ""));
  add("Fréchet distance, trained on one half and judged on the other", overall.half_frechet_ratio, std::nullopt, 1.3,
      "all styles together; over the mean distance of random halves");
  worst = WorstOf(styles, [](const Likeness& s) { return s.half_frechet_ratio; });
  add("the same, worst style", worst.value, std::nullopt, 1.6, named(worst, ""));
  worst = WorstOf(styles, [](const Likeness& s) { return DifferenceOf(s.told); });
  add("classifier's area under the curve above its floor, worst style", worst.value, std::nullopt, 0.05,
      named(worst, areas_of(worst.style, [&](const Likeness& s) { return all_of(s.told); })));
  worst = WorstOf(styles, [](const Likeness& s) { return DifferenceOf(s.half_told); });
  add("the same, trained on one half and judged on the other, worst style", worst.value, std::nullopt, 0.10,
      named(worst, areas_of(worst.style, [&](const Likeness& s) { return halves_of(s.half_told); })));
  worst = WorstOf(styles, [](const Likeness& s) { return DifferenceOf(s.copies_told); });
  add("the same for captured clips of the learned half, drawn with repetition, worst style", worst.value, std::nullopt, std::nullopt,
      named(worst, areas_of(worst.style, [&](const Likeness& s) { return halves_of(s.copies_told); })));
  worst = WorstOf(styles, [](const Likeness& s) {
    return s.half_told && s.copies_told ? std::optional(s.half_told->auc() - s.copies_told->auc()) : std::nullopt;
  });
  add("area of models of one half above that of these captured clips, worst style", worst.value, std::nullopt, std::nullopt, named(worst, ""));
  worst = WorstOf(styles, [](const Likeness& s) { return DifferenceOf(s.told_by_bones); });
  if (worst.value) {
    add("classifier's area above its floor where captured clips keep the bones that they were recorded on, worst style", worst.value, std::nullopt, std::nullopt,
        named(worst, areas_of(worst.style, [&](const Likeness& s) { return all_of(s.told_by_bones); })));
  }
  const auto diversity = [](const Likeness& s) { return s.diversity_ratio; };
  worst = WorstOf(styles, diversity, false);
  add("diversity of one style's clips / captured, least", worst.value, 0.9, 1.1, named(worst, ""));
  worst = WorstOf(styles, diversity, true);
  add("diversity of one style's clips / captured, greatest", worst.value, 0.9, 1.1, named(worst, ""));
}

void AddLikenessCharts(const LikenessCut& cut, const Likeness& overall, const LikenessByStyle& styles, StudySection* section) {
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

}  // namespace morphograph
