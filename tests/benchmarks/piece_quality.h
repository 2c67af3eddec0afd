#pragma once

#include <map>
#include <string>
#include <vector>

#include "datasets/motion_clip.h"
#include "graph/motion_graph.h"
#include "synthesis/control/swing_range.h"

namespace morphograph::bench {

/// Three seconds of a clip: how much they turn, and the measures in which turns differ from straight walks.
struct PieceQuality {
  std::string style;
  int clip = 0;             // of the set
  double turn_rad = 0;      // sum of |change of heading| from second to second, so that the sway of a stride does not count
  double speed_m_s = 0;     // length of the root's way from second to second
  double contact_m = 0, skate_cm_s = 0, naturalness = 0;
};

/// Pieces as MeasureSet() cuts them (SetQualityOptions).
std::vector<PieceQuality> MeasurePieces(const std::vector<MotionClip>& clips);

/// The fastest and the highest that the ball of a foot comes: of each clip.
std::vector<ClipSwing> MeasureSwings(const std::vector<MotionClip>& clips);
/// What 99 of 100 captured steps keep to, by style; nothing where the model keeps no recordings.
std::map<std::string, ClipSwing> CapturedSwings(const MotionGraph& graph);

struct MeanQuality {
  int pieces = 0;
  double turn_rad = 0, speed_m_s = 0, contact_m = 0, skate_cm_s = 0, naturalness = 0;

  /// Adds another's values, so many times.
  void Add(const MeanQuality& other, int times);
};

/// Means by style of the pieces that turn by at least `least_rad` and at most `most_rad`.
std::map<std::string, MeanQuality> MeansByStyle(const std::vector<PieceQuality>& pieces, double least_rad, double most_rad);

}  // namespace morphograph::bench
