#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "graph/motion_graph.h"
#include "synthesis/synthesis_variant.h"

namespace morphograph {

/// Clips by style.
using StyledClips = std::map<std::string, std::vector<MotionClip>>;

/// The clips at the 30 fps of the evaluation, on `jobs` threads.
std::vector<MotionClip> AtEvaluationRate(const std::vector<MotionClip>& clips, int jobs);

/// Some of the clips, by position.
std::vector<MotionClip> Chosen(const std::vector<MotionClip>& clips, const std::vector<int>& which);

StyledClips ByStyle(const std::vector<MotionClip>& clips);

/// Whether all clips have the same bones.
bool OfOneBody(const std::vector<MotionClip>& clips);

/// The clips with the bones of one skeleton, as training reads them: a model draws on one, and poses of other bones are known by these, whatever
/// the motion. @throws std::invalid_argument as Retarget().
std::vector<MotionClip> OnBody(const std::vector<MotionClip>& clips, const std::shared_ptr<const Skeleton>& skeleton, int jobs);

/// All clips, style after style.
std::vector<MotionClip> Joined(const StyledClips& clips);

/// Frames of the pieces that sets are cut into to be measured: 90, or, where fewer than three of four clips hold as many, the longest of
/// 75, 60, 45, 30 and 15 that as many do. @param clips  at 30 fps. @throws std::invalid_argument when not even 15 fit.
int PieceFrames(const std::vector<MotionClip>& clips);

struct DrawOptions {
  int clips = 100;  // of each style
  double duration_s = 10;
  std::uint64_t seed = 1;  // of the first clip; the others follow
  int jobs = 1;
  SynthesisVariant variant = {};
};

/// Synthesised clips at 30 fps of one style of the graph. @throws UnsatisfiableRequest when it cannot walk in that style.
std::vector<MotionClip> DrawClips(const MotionGraph& graph, const std::string& style, const DrawOptions& options);

/// The same of every style that the graph can walk in; others are named in `missing`.
StyledClips DrawStyles(const MotionGraph& graph, const DrawOptions& options, std::vector<std::string>* missing = nullptr);

/// Of each style, whose clips are all of one length, as many as its part in the time of the captured clips, at most all: a set that compares
/// with all captured clips together.
std::vector<MotionClip> InProportion(const StyledClips& synthesised, const StyledClips& captured);

/// "all", or a style's name, for charts and tables.
std::string StyleLabel(const std::string& style);

}  // namespace morphograph
