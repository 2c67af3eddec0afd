// Synthesised against captured clips as sets: Fréchet distance, diversity, classifier. METHODS section 6.

#include <array>

#include "api/study/likeness.h"
#include "api/study/likeness_figures.h"
#include "api/study/sample_sets.h"
#include "api/study/sample_study.h"

namespace morphograph {
namespace {

// Halves of the clips, and what a model of each has synthesised.
struct LearnedHalves {
  StudyContext::Halves clips;
  StyledClips synthesised[2];
};

}  // namespace

StudySection StudyLikeness(StudyContext& context) {
  const StudyOptions& options = context.options();
  const std::vector<MotionClip>& recorded = context.clips(StudyData::kClean);
  const std::vector<MotionClip> captured = AtEvaluationRate(OnBody(recorded, context.body(), options.jobs), options.jobs);
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
  std::vector<MotionClip> with_own_bones;  // where these tell something
  if (!OfOneBody(recorded)) {
    with_own_bones = AtEvaluationRate(recorded, options.jobs);
    section.text +=
        "\n\nThese clips are of bodies with different bones, and a model has one. Captured clips are put on its body, as training does, for a classifier "
        "knows a clip by the length of its bones, whatever the motion. What it tells when they keep their own bones is given beside that.";
  }
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

  const std::vector<LikenessCut> cuts = {{"clips as they are", "whole", false, 12}, {"a second off both ends", "trimmed", true, 12}};
  for (size_t c = 0; c < cuts.size(); ++c) {
    const LikenessCut& cut = cuts[c];
    const std::vector<MotionClip> clips = CutClips(captured, cut);
    if (clips.size() < 4) {
      section.text += "\n\nToo few clips are long enough to take a second off both ends.";
      section.data[cut.id] = nullptr;
      continue;
    }
    const StyledClips by_style = ByStyle(clips);
    const StyledClips own_bones_by_style = ByStyle(CutClips(with_own_bones, cut));
    std::vector<std::array<StyledClips, 2>> by_half;  // of every halving
    for (const LearnedHalves& halves : learned) {
      by_half.push_back({ByStyle(CutClips(Chosen(captured, halves.clips[0]), cut)), ByStyle(CutClips(Chosen(captured, halves.clips[1]), cut))});
    }
    const auto of = [](const StyledClips& set, const std::string& style) {
      const auto at = set.find(style);
      return at == set.end() ? std::vector<MotionClip>() : at->second;
    };
    LikenessByStyle styles;
    for (const auto& [style, drawn] : synthesised) {
      tell("comparing " + StyleLabel(style), 0.25 + 0.75 * (static_cast<double>(c) + static_cast<double>(styles.size()) / static_cast<double>(synthesised.size())) / static_cast<double>(cuts.size()));
      Likeness likeness;
      const std::vector<MotionClip> own = of(by_style, style);
      JudgeWhole(drawn, own, options, &likeness);
      likeness.told = Tell(drawn, own, cut, options);
      if (!with_own_bones.empty()) likeness.told_by_bones = Tell(drawn, of(own_bones_by_style, style), cut, options);
      std::vector<JudgedHalves> of_style;
      for (size_t n = 0; n < learned.size(); ++n) {
        const auto& [first, second] = learned[n].synthesised;
        of_style.push_back({{of(first, style), of(second, style)}, {of(by_half[n][0], style), of(by_half[n][1], style)}});
      }
      JudgeHalves(of_style, static_cast<int>(styles.size()), options, &likeness);
      section.data[cut.id]["styles"][StyleLabel(style)] = LikenessJson(likeness);
      styles.emplace_back(style, likeness);
    }
    Likeness overall;
    if (styles.size() == 1) {
      overall = styles.front().second;
    } else {
      JudgeWhole(InProportion(synthesised, by_style), clips, options, &overall);
      std::vector<JudgedHalves> of_all;
      for (size_t n = 0; n < learned.size(); ++n) {
        const auto& [first, second] = learned[n].synthesised;
        of_all.push_back({{InProportion(first, by_half[n][0]), InProportion(second, by_half[n][1])}, {Joined(by_half[n][0]), Joined(by_half[n][1])}});
      }
      JudgeHalves(of_all, std::nullopt, options, &overall);
    }
    section.data[cut.id]["all_styles_together"] = LikenessJson(overall);
    AddLikenessFigures(cut, overall, styles, &section);
    AddLikenessCharts(cut, overall, styles, &section);
  }
  return section;
}

}  // namespace morphograph
