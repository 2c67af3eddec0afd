#pragma once

#include <memory>
#include <vector>

#include "synthesis/sensors/olng_model.h"

namespace morphograph {

/// Poses of paths through the base (Tautges et al. 2011, sections 5 and 6): each is that of least energy under priors from the ends of its best paths, of the reading and of
/// the two poses made before; the root goes as these paths do on the average, faster or slower as they do. Backwards the poses made before are those that follow in time:
/// differences are taken the other way, accelerations are the same.
///
/// Departures: priors are regularised normal distributions unless PriorKind::kKernel asks for the published kernels. Eq. 1 takes the (I+1)-th cost for the largest, so that
/// no path is left without weight and I = 1 is defined. Eq. 6 as printed lands one frame late; with -1/2 a dt^2 it is the difference of the neighbour's last two frames.
/// Eq. 9 is centred at t, and so are the accelerations it is compared with. Eq. 10 takes velocities at the paths' previous frames, and for gravity the tilt of the pose
/// before, which the neighbours gave. Velocities and accelerations are scaled by the tempo of the path and its square. Terms that go on from the pose before gain their
/// weight as paths do: after t readings 1 - (1 - 1/M)^t of it, for the first poses are little more than guesses.
class PathPoser {
 public:
  /// @throws std::invalid_argument where the model is to take the nearest frame alone.
  explicit PathPoser(std::shared_ptr<const OlngModel> model, TimeDirection direction = TimeDirection::kForwards);

  /// The next pose. @param reading  (3 * sensors). @param paths  that end in its frame, in any order, at least one, each ending in a frame of the base.
  /// @throws std::invalid_argument for a reading of another size or not finite, or other paths.
  BasePose Next(const Eigen::VectorXd& reading, std::vector<NeighbourPath> paths);

  /// The paths that the last pose was made of, best first, and their weights.
  const std::vector<NeighbourPath>& best_paths() const { return best_; }
  const Eigen::VectorXd& weights() const { return weights_; }
  /// How far the next pose will go by those made before, in [0, 1): 0 at first.
  double trust() const { return trust_; }

 private:
  void KeepBest(std::vector<NeighbourPath> paths);
  NeighbourhoodTargets Targets() const;
  bool Joined(Eigen::Index frame) const;  // whether the base has a frame before it in the direction of time

  std::shared_ptr<const OlngModel> model_;
  int step_;  // 1 or -1: from a frame of the base to the next
  std::vector<NeighbourPath> best_;
  Eigen::VectorXd weights_;
  double trust_ = 0;                     // in the pose before
  Eigen::VectorXd reading_, rotations_;  // of the frame before; empty at first
  Eigen::VectorXd positions_, older_positions_;
};

}  // namespace morphograph
