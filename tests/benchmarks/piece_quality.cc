#include "tests/benchmarks/piece_quality.h"

#include <algorithm>
#include <cmath>

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
