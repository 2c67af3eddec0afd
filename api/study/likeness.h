#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/study/study_context.h"
#include "datasets/motion_clip.h"
#include "synthesis/window_classifier.h"

namespace morphograph {

/// One way to cut the captured clips, and how closely they are then looked at.
struct LikenessCut {
  std::string name;      // "clips as they are"
  std::string id;        // in the data
  bool trimmed = false;  // by a second at both ends
  int halvings = 1;      // of the captured clips, that the classifier's figures are averaged over
};

/// Clips cut so; those that are too short for it are left out. @param clips  at 30 fps.
std::vector<MotionClip> CutClips(const std::vector<MotionClip>& clips, const LikenessCut& cut);

/// How well clips made of one half of the captured ones are told from the other half.
struct HalfDistinction {
  std::vector<double> areas;  // under the curve, a value a halving; mean of both ways
  double floor = 0;

  double auc() const;
  double difference() const { return auc() - floor; }
};

/// How synthesised clips of a style, or of all, compare with captured ones as sets (METHODS section 6). What is absent the clips are too few for.
struct Likeness {
  std::optional<double> frechet_ratio, diversity_ratio;   // trained on all
  std::optional<double> halves_distance;                  // of random halves of the captured clips, mean
  std::optional<double> half_frechet_ratio;               // trained on one half, judged on the other
  std::optional<WindowDistinction> told;                  // trained on all
  std::optional<WindowDistinction> told_by_bones;         // the same, captured clips with the bones that they were recorded on
  std::optional<HalfDistinction> half_told, copies_told;  // clips of models of one half, and of that half itself, judged on the other
  std::string note;                                       // why something is absent
};

/// Styles by name, with "" for clips of none.
using LikenessByStyle = std::vector<std::pair<std::string, Likeness>>;

/// The two halves of the captured clips, and what models of each have synthesised.
struct JudgedHalves {
  std::vector<MotionClip> synthesised[2], captured[2];

  bool drawn() const { return !synthesised[0].empty() && !synthesised[1].empty(); }
};

/// How well a forest tells two sets apart; absent where halves of the captured clips cannot fill two folds.
std::optional<WindowDistinction> Tell(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured, const LikenessCut& cut,
                                      const StudyOptions& options);

/// Of a model of all clips: Fréchet distance and diversity; the forest is Tell()'s.
void JudgeWhole(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured, const StudyOptions& options, Likeness* likeness);

/// Of models of halves, means over the halvings, each judged on the half that it has not seen. Distances are over that between random halves that
/// JudgeWhole() found, as these few vary by a factor of three from one to the next.
/// @param style  number of the style, for seeds: told apart too, by the floor of `told`; absent for all styles together.
void JudgeHalves(const std::vector<JudgedHalves>& halvings, std::optional<int> style, const StudyOptions& options, Likeness* likeness);

}  // namespace morphograph
