#include "datasets/floor_leveling.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "datasets/quantile.h"
#include "datasets/turn_between.h"

namespace morphograph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// How far the floor rises over the ground that the clip covers.
double Rise(const MotionClip& clip, const Eigen::Vector2d& slope) {
  const Eigen::VectorXd along = slope.x() * clip.root_positions().row(0) + slope.y() * clip.root_positions().row(2);
  return along.maxCoeff() - along.minCoeff();
}

}  // namespace

MotionClip LevelFloor(const MotionClip& clip, const ContactTrack& contacts, const FloorLevelingOptions& options,
                      FloorLevelingReport* report) {
  if (clip.frame_count() == 0) throw std::invalid_argument("LevelFloor: '" + clip.name + "' has no frame");
  FloorLevelingReport done;
  MotionClip level = clip;
  const int root = clip.skeleton().moving_root();
  double height_m = 0;
  if (contacts.plane) {
    const FloorPlane& plane = *contacts.plane;
    height_m = plane.height_m;
    if (Rise(clip, plane.slope) > options.tolerance_m) {
      done.slope = plane.slope;
      const Vector3d pivot(plane.origin.x(), plane.height_m, plane.origin.y());
      const Vector3d normal = Vector3d(-plane.slope.x(), 1, -plane.slope.y()).normalized();
      const Quaterniond turn = TurnBetween(normal, Vector3d::UnitY());
      for (int f = 0; f < clip.frame_count(); ++f) {
        level.rotation(f, root) = (turn * clip.rotation(f, root)).normalized();
        level.root_positions().col(f) = turn * (clip.root_positions().col(f) - pivot) + pivot;
      }
    }
  } else {
    done.uneven = true;
    height_m = Median({contacts.ground_m.begin(), contacts.ground_m.end()});
  }
  if (std::abs(height_m - options.ball_height_m) > options.tolerance_m) {
    done.shift_m = options.ball_height_m - height_m;
    level.root_positions().row(1).array() += done.shift_m;
  }
  if (report) *report = done;
  return level;
}

MotionClip LevelFloor(const MotionClip& clip, const FloorLevelingOptions& options, FloorLevelingReport* report) {
  return LevelFloor(clip, DetectContacts(clip), options, report);
}

}  // namespace morphograph
