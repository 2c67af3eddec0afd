#pragma once

#include <memory>
#include <string>
#include <vector>

#include "synthesis/sensors/class_forest.h"
#include "synthesis/sensors/marker_selection.h"
#include "synthesis/sensors/marker_tracks.h"
#include "synthesis/sensors/motion_segmentation.h"
#include "synthesis/sensors/pose_estimator.h"

namespace morphograph {

struct MarkerOptions {
  MarkerSelectionOptions selection;
  /// Markers that are given, by name; empty: the principal ones.
  std::vector<std::string> given;
  /// Markers that define the frame, by name, and are given too (as those at the neck and shoulders of Liu 4.1); empty: the given ones define it.
  std::vector<std::string> frame;
  SegmentationOptions segmentation;
  SegmentClusterOptions clusters;
  ClassForestOptions forest;
  double history_s = 0.1;   // maps and forest see where the given markers were so long ago as well (Liu: 0, the present only)
  double ridge = 1e-5;      // of the maps, in variances of the inputs
  double mixture_s = 0.15;  // time over which probabilities are averaged (Liu's h; 0.08 to 0.25 s there)
  int jobs = 1;
};

/// What the method learns (Liu 3): which markers to wear, clusters of motion with a linear map each, and the forest that tells clusters apart. Immutable;
/// streams share it.
struct MarkerModel {
  /// @param markers  the full set, as FullBodyMarkers() makes it.
  /// @throws std::invalid_argument for a name that is not among them, or options out of range.
  MarkerModel(const MotionBase& base, const std::vector<Placement>& markers, const MarkerOptions& options);

  MarkerOptions options;
  double frame_rate_hz = 0;
  std::vector<Placement> markers;   // the full set
  std::vector<int> given;           // of it
  std::vector<int> frame_markers;   // of it; empty: `given` define the frame
  std::vector<int> others;          // of it: those that are not given
  MarkerFrame frame;
  /// What brings the frame nearer to the body's own: from the input seen in `frame` to the moving root's floor position and heading, (3 x (1 + inputs)); empty
  /// with frame markers. Six markers on limbs that swing define a frame that swings.
  Eigen::MatrixXf frame_map;
  int segment_count = 0, cluster_count = 0;
  std::unique_ptr<ClassForest> forest;   // null with one cluster
  /// Frames back to the past places in the input; 0: the input has none.
  int history = 0;
  /// Of each cluster, (outputs x (1 + inputs)): intercept and slope, from the given markers now (and how they came there) to those of all markers that are not given, in the frame
  /// (3 * others) …
  std::vector<Eigen::MatrixXf> marker_maps;
  /// … and to rotations, the moving root's floor position (x, z) and heading in the frame, and its height.
  std::vector<Eigen::MatrixXf> pose_maps;

  /// Number of values of a reading: the given markers, then those of the frame.
  Eigen::Index reading_size() const { return 3 * static_cast<Eigen::Index>(given.size() + frame_markers.size()); }
  /// The frame in which maps and forest see things. @param before  where the given markers were `history` frames ago, empty without history.
  /// @param input  what they see there is left in it.
  MarkerFrame::Place FrameOf(const Eigen::Ref<const Eigen::VectorXd>& frame_points, const Eigen::Ref<const Eigen::VectorXd>& now,
                             const Eigen::Ref<const Eigen::VectorXd>& before, Eigen::VectorXf* input) const;
  /// The markers of a reading, in order.
  std::vector<Placement> ReadingMarkers() const;
};

/// All markers, and the pose, from a few markers (Liu 3.4): a reading is turned into the markers' own frame, the forest says how likely each cluster is, these
/// probabilities are averaged over the last tenths of a second, and the clusters' linear maps are mixed by them.
///
/// Differs from Liu: the input also has the way of each marker over the last tenth of a second, seen from the present frame; maps have an intercept; probabilities are mixed, not votes; the time of averaging is in seconds, not frames; and the skeleton's
/// pose is mapped along with the markers. No delay but that of the mixture's weights.
class MarkerEstimator : public PoseEstimator {
 public:
  explicit MarkerEstimator(std::shared_ptr<const MarkerModel> model);
  /// @param reading  positions (m, Y up, any place and heading) of the given markers, then of those of the frame.
  BasePose Next(const Eigen::VectorXd& reading) override;
  /// The same frame's step without the pose: all markers, (3 x markers), in the reading's space. Call one of the two for each frame.
  Eigen::Matrix3Xd NextMarkers(const Eigen::VectorXd& reading);

 private:
  // Weighs clusters by the reading; leaves the input of the maps in input_.
  MarkerFrame::Place Weigh(const Eigen::VectorXd& reading);
  // The maps of the clusters mixed by their weights, applied to input_; left in mixed_.
  const Eigen::VectorXf& Mixed(const std::vector<Eigen::MatrixXf>& maps);

  std::shared_ptr<const MarkerModel> model_;
  Eigen::MatrixXd past_;    // (3 * given x history + 1): readings, cyclic
  Eigen::MatrixXf recent_;  // (clusters x frames of the mixture), cyclic
  Eigen::Index count_ = 0;
  Eigen::VectorXf weights_, input_, mixed_;
  // Where the moving root was: floor position and heading, in the reading's space.
  bool moved_ = false;
  Eigen::Vector2d place_ = Eigen::Vector2d::Zero();
  double heading_rad_ = 0;
};

}  // namespace morphograph
