#pragma once

#include <memory>
#include <string>
#include <vector>

#include "graph/action_change.h"
#include "graph/transition_model.h"
#include "primitives/motion_primitive.h"
#include "primitives/pose_layout.h"

namespace morphograph {

/// Where a model comes from; kept in its file and shown by `inspect`.
struct ModelProvenance {
  std::string source;       // of the recordings
  std::string licence;
  std::string attribution;  // text that must be kept
  std::string command;      // that made the model
  int clips = 0;
  int frames = 0;
  std::vector<std::string> notes;  // what training could not learn, dead ends
};

/// Where the feet of a style touch the floor; index 0 is the left foot.
struct FeetGeometry {
  /// The heel, fixed in the foot, in the frame of the ankle joint.
  Eigen::Vector3d heel_offset_m[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double heel_height_m[2] = {0, 0};  // over the floor, while planted
  double ball_height_m[2] = {0, 0};
  /// How low they come while the foot rolls, over the floor. They lie inside the foot, so that this may be less than where they stand.
  double heel_lowest_m[2] = {0, 0};
  double ball_lowest_m[2] = {0, 0};
};

/// A style of one action: what a walk keeps to from its first step to its last.
struct GraphStyle {
  std::string name;  // empty where the data has no styles
  MeanRotations mean_rotations;  // the same for all actions of a style
  FeetGeometry feet;
  std::string other_action = {};  // than the graph's own; empty: that one
};

struct GraphEdge {
  int from = 0;  // primitive ids
  int to = 0;
  TransitionModel model;
};

struct RecordedMotion;

/// Everything a graph is made of, before it is frozen.
struct GraphContents {
  std::string name;
  std::string action;
  double frame_rate_hz = 30;  // of clips, unless a request asks otherwise
  ModelProvenance provenance;
  PoseLayout layout;
  std::vector<GraphStyle> styles;
  std::vector<MotionPrimitive> primitives;
  std::vector<GraphEdge> edges;
  std::shared_ptr<const RecordedMotion> recordings;  // what it was learned from, where that is kept
  std::vector<ActionChange> changes = {};
};

/// The learned motion graph: vertex = primitive, edge = transition. Immutable and safe to share between threads.
///
/// Guarantees: sizes agree throughout, edge ends exist, numbers are finite, legs have roles, probabilities of leaving a vertex sum to 1. Ids are positions in
/// `primitives()` and `edges()`, stable for the life of a model.
class MotionGraph {
 public:
  /// @param hash  content hash of the model file, hex.
  /// @throws std::invalid_argument naming the primitive or edge whose sizes do not agree.
  MotionGraph(GraphContents contents, std::string hash);
  ~MotionGraph();
  MotionGraph(const MotionGraph&) = delete;
  MotionGraph& operator=(const MotionGraph&) = delete;

  const std::string& name() const;
  const std::string& action() const;
  const std::string& hash() const;
  double frame_rate_hz() const;
  const ModelProvenance& provenance() const;
  const PoseLayout& layout() const;
  const Skeleton& skeleton() const;
  const std::shared_ptr<const Skeleton>& shared_skeleton() const;
  const std::vector<GraphStyle>& styles() const;
  /// The captured clips that the model was learned from (graph/recorded_motion.h); null where its file does not keep them.
  const std::shared_ptr<const RecordedMotion>& recordings() const;
  /// Names of the styles of the graph's own action, without the empty one.
  std::vector<std::string> style_names() const { return style_names(action()); }
  /// Of any action.
  std::vector<std::string> style_names(const std::string& action) const;
  /// The action of one of `styles()`.
  const std::string& action_of(const GraphStyle& style) const { return style.other_action.empty() ? action() : style.other_action; }
  /// The graph's own action, then others, sorted by name.
  std::vector<std::string> action_names() const;

  int primitive_count() const;
  const MotionPrimitive& primitive(int id) const;
  int edge_count() const;
  int edge_from(int id) const;
  int edge_to(int id) const;
  const TransitionModel& transition(int id) const;
  /// Edge ids that leave a primitive, by ascending id.
  const std::vector<int>& out_edges(int primitive) const;
  /// Made steps from one action into another, which no edge leads to: walks take them only where they are asked to.
  const std::vector<ActionChange>& changes() const;
  bool is_dead_end(int primitive) const { return out_edges(primitive).empty(); }

 private:
  struct Storage;  // hides Boost.Graph
  std::unique_ptr<const Storage> storage_;
};

}  // namespace morphograph
