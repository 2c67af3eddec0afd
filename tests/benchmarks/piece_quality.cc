#include "tests/benchmarks/piece_quality.h"

#include <algorithm>
#include <cmath>

#include "datasets/quantile.h"
#include "graph/recorded_motion.h"
#include "synthesis/set_quality.h"

namespace morphograph::bench {

std::vector<PieceQuality> MeasurePieces(const std::vector<MotionClip>& clips) {
  constexpr int kSecond = 30;
  const int frames = SetQualityOptions().piece_frames;
  std::vector<PieceQuality> pieces;
  for (size_t c = 0; c < clips.size(); ++c) {
    for (int first = 0; first + frames <= clips[c].frame_count(); first += frames) {
      const MotionClip slice = clips[c].Slice(first, frames);
      const SetQuality quality = MeasureSet({slice});
      PieceQuality piece{clips[c].style, static_cast<int>(c)};
      for (int f = 0; f + 1 < frames; f += kSecond) {
        const int next = std::min(f + kSecond, frames - 1);
        const Eigen::Vector3d way = slice.root_positions().col(next) - slice.root_positions().col(f);
        piece.turn_rad += std::abs(std::remainder(HeadingRad(slice, next) - HeadingRad(slice, f), 2 * M_PI));
        piece.speed_m_s += std::hypot(way.x(), way.z()) * kSecond / (frames - 1);
      }
      piece.contact_m = quality.contact_distance_m;
      piece.skate_cm_s = quality.foot_skate_cm_s;
      piece.naturalness = quality.naturalness;
      pieces.push_back(std::move(piece));
    }
  }
  return pieces;
}

std::vector<ClipSwing> MeasureSwings(const std::vector<MotionClip>& clips) {
  std::vector<ClipSwing> swings;
  for (const MotionClip& clip : clips) {
    const ClipSwing left = SwingInClip(clip, Foot::kLeft, 0, clip.frame_count() - 1), right = SwingInClip(clip, Foot::kRight, 0, clip.frame_count() - 1);
    swings.push_back({std::max(left.speed_m_s, right.speed_m_s), std::max(left.height_m, right.height_m)});
  }
  return swings;
}

std::map<std::string, ClipSwing> CapturedSwings(const MotionGraph& graph) {
  std::map<std::string, ClipSwing> largest;
  if (!graph.recordings()) return largest;
  const std::vector<MotionClip> clips = RecordedClips(*graph.recordings(), graph.layout(), graph.styles()[0].mean_rotations);
  std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> steps;  // speeds, heights
  for (const RecordedStep& step : graph.recordings()->steps) {
    const MotionClip& clip = clips[static_cast<size_t>(step.clip)];
    const int last = std::min(clip.frame_count() - 1, static_cast<int>(std::ceil(step.end_frame)));
    const ClipSwing swing = SwingInClip(clip, step.left ? Foot::kLeft : Foot::kRight, static_cast<int>(step.start_frame), last);
    steps[clip.style].first.push_back(swing.speed_m_s);
    steps[clip.style].second.push_back(swing.height_m);
  }
  for (const auto& [style, values] : steps) largest[style] = {Quantile(values.first, 0.99), Quantile(values.second, 0.99)};
  return largest;
}

void MeanQuality::Add(const MeanQuality& other, int times) {
  pieces += times;
  turn_rad += times * other.turn_rad;
  speed_m_s += times * other.speed_m_s;
  contact_m += times * other.contact_m;
  skate_cm_s += times * other.skate_cm_s;
  naturalness += times * other.naturalness;
}

std::map<std::string, MeanQuality> MeansByStyle(const std::vector<PieceQuality>& pieces, double least_rad, double most_rad) {
  std::map<std::string, MeanQuality> means;
  for (const PieceQuality& piece : pieces) {
    if (piece.turn_rad < least_rad || piece.turn_rad > most_rad) continue;
    means[piece.style].Add({1, piece.turn_rad, piece.speed_m_s, piece.contact_m, piece.skate_cm_s, piece.naturalness}, 1);
  }
  for (auto& [style, mean] : means) {
    for (double* sum : {&mean.turn_rad, &mean.speed_m_s, &mean.contact_m, &mean.skate_cm_s, &mean.naturalness}) *sum /= mean.pieces;
  }
  return means;
}

}  // namespace morphograph::bench
