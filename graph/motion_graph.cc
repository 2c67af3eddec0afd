#include "graph/motion_graph.h"

#include <boost/graph/adjacency_list.hpp>
#include <cmath>
#include <set>
#include <stdexcept>

#include "graph/recorded_motion.h"

namespace morphograph {
namespace {

void Require(bool condition, const std::string& what) {
  if (!condition) throw std::invalid_argument("MotionGraph: " + what);
}

void CheckPrimitive(const MotionPrimitive& primitive, const GraphContents& contents) {
  const std::string name = "primitive '" + primitive.name + "' (" + primitive.style + "): ";
  const Eigen::Index values = contents.layout.channels() * kPhaseSamples + kTimingValues;
  Require(primitive.reduction.mean.size() == values && primitive.reduction.basis.rows() == values,
          name + "vectors do not fit the pose layout");
  Require(primitive.mixture.size() > 0 && primitive.mixture.dimension() == primitive.reduction.components(),
          name + "mixture does not fit the reduction");
  Require(primitive.style_index >= 0 && primitive.style_index < static_cast<int>(contents.styles.size()),
          name + "no such style");
  Require(primitive.reduction.mean.allFinite() && primitive.reduction.basis.allFinite() && primitive.contacts.allFinite() &&
              std::isfinite(primitive.latent_radius) && primitive.latent_radius >= 0 &&
              std::isfinite(primitive.initial_weight) && primitive.initial_weight >= 0,
          name + "a number is not finite, or negative");
  Require(primitive.contacts.rows() == kContactRows && primitive.contacts.cols() == kPhaseSamples, name + "contacts of the wrong size");
  const Eigen::MatrixXf& map = primitive.contact_map;
  Require(map.size() == 0 || (map.rows() == kContactRows * kPhaseSamples && map.cols() == primitive.reduction.components() && map.allFinite()),
          name + "contact_map does not fit the reduction, or holds a number that is not finite");
  const MannerModel& manner = primitive.manner;
  if (manner.empty()) return;
  Require(manner.share.size() == primitive.reduction.components() && manner.captured.rows() == manner.share.size() &&
              manner.captured.cols() == static_cast<Eigen::Index>(manner.steps.size()) && manner.seconds.size() == manner.steps.size() &&
              manner.components.rows() == primitive.mixture.size() && manner.components.cols() == manner.captured.cols() &&
              manner.met.rows() == manner.components.rows() && manner.met.cols() == manner.components.cols(),
          name + "manner does not fit the reduction");
  Require(manner.captured.allFinite() && manner.components.allFinite() && manner.components.minCoeff() > 0 && manner.met.allFinite() && manner.met.minCoeff() >= 0 && (manner.met.colwise().sum().array() - 1).abs().maxCoeff() < 1e-3f && manner.share.minCoeff() >= 0 && manner.share.maxCoeff() < 1, name + "manner has shares outside [0, 1), or factors or meetings that are none");
  for (size_t walk = 0; walk < manner.steps.size(); ++walk) {
    Require(manner.steps[walk] >= 0 && std::isfinite(manner.seconds[walk]) && manner.seconds[walk] >= 0, name + "a walk of the manner is negative");
  }
  for (const MotionPrimitive& other : contents.primitives) {
    Require(other.style_index != primitive.style_index || other.manner.empty() || other.manner.walks() == manner.walks(),
            name + "manner is of other walks than that of '" + other.name + "'");
  }
}

void CheckEdge(const GraphEdge& edge, size_t index, const std::vector<MotionPrimitive>& primitives) {
  const std::string name = "edge " + std::to_string(index) + ": ";
  const int count = static_cast<int>(primitives.size());
  Require(edge.from >= 0 && edge.from < count && edge.to >= 0 && edge.to < count, name + "joins no such primitives");
  const MotionPrimitive& from = primitives[edge.from];
  const MotionPrimitive& to = primitives[edge.to];
  const TransitionModel& model = edge.model;
  Require(model.linear.rows() == to.reduction.components() && model.linear.cols() == from.reduction.components(),
          name + "linear part does not fit its primitives");
  Require(model.component_chances.rows() == from.mixture.size() && model.component_chances.cols() == to.mixture.size(),
          name + "component chances do not fit its primitives");
  Require(model.residuals.cols() == static_cast<Eigen::Index>(model.residual_component.size()) &&
              (model.residuals.cols() == 0 || model.residuals.rows() == to.reduction.components()),
          name + "residuals do not fit its target");
  Require(model.noise_cholesky.rows() == to.reduction.components() && model.noise_cholesky.cols() == model.noise_cholesky.rows(),
          name + "noise does not fit its target");
  for (const int component : model.residual_component) {
    Require(component >= 0 && component < to.mixture.size(), name + "a residual belongs to no component of its target");
  }
  Require(!model.process || (model.process->input_dimension() == from.reduction.components() &&
                             model.process->output_dimension() == to.reduction.components()),
          name + "process does not fit its primitives");
  Require(model.linear.allFinite() && model.residuals.allFinite() && model.noise_cholesky.allFinite() &&
              model.component_chances.allFinite(),
          name + "a number is not finite");
  Require(model.probability > 0 && model.probability <= 1 + 1e-9, name + "probability is not in (0, 1]");
}

void CheckChange(const ActionChange& change, const GraphContents& contents) {
  const std::string name = "change '" + change.name + "': ";
  const int count = static_cast<int>(contents.primitives.size());
  Require(change.from >= 0 && change.from < count && change.to >= 0 && change.to < count, name + "joins no such primitives");
  const MotionPrimitive &from = contents.primitives[change.from], &to = contents.primitives[change.to];
  const GraphStyle &before = contents.styles[from.style_index], &after = contents.styles[to.style_index];
  Require(before.name == after.name && before.other_action != after.other_action, name + "does not lead from one action of a style into another");
  Require(from.start == to.start && from.end == to.end, name + "its steps are not of the same foot");
  Require(std::isfinite(change.captured.speed_m_s2) && std::isfinite(change.captured.body_m_s2), name + "a number is not finite");
}

}  // namespace

struct MotionGraph::Storage {
  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, MotionPrimitive, TransitionModel>;
  using Edge = boost::graph_traits<Graph>::edge_descriptor;

  GraphContents header;  // without primitives and edges, which live in `graph`
  std::string hash;
  Graph graph;
  std::vector<Edge> edges;                  // by our own id
  std::vector<std::vector<int>> out_edges;  // ids that leave a primitive
};

MotionGraph::MotionGraph(GraphContents contents, std::string hash) {
  Require(!contents.primitives.empty(), "no primitives");
  Require(!contents.layout.active_joints().empty(), "no pose layout");
  Require(contents.frame_rate_hz > 0 && std::isfinite(contents.frame_rate_hz), "frame rate must be positive");
  const std::vector<int>& active = contents.layout.active_joints();
  const std::set<int> distinct(active.begin(), active.end());
  Require(distinct.size() == active.size() && *distinct.begin() >= 0 &&
              *distinct.rbegin() < contents.layout.skeleton().joint_count(),
          "an active joint stands twice or is not there");
  Require(contents.layout.skeleton().roles().Missing(LocomotionRoles()).empty(), "a joint of the legs has no role");
  for (const GraphStyle& style : contents.styles) {
    Require(static_cast<int>(style.mean_rotations.size()) == contents.layout.skeleton().joint_count(),
            "mean rotations of style '" + style.name + "' do not fit the skeleton");
    Require(style.other_action.empty() || style.other_action != contents.action, "style '" + style.name + "' names the graph's own action as another");
  }
  if (contents.recordings) {
    const std::string problem = contents.recordings->Problem(contents.layout);
    Require(problem.empty(), problem);
  }
  auto storage = std::make_unique<Storage>();
  for (const MotionPrimitive& primitive : contents.primitives) CheckPrimitive(primitive, contents);
  storage->out_edges.resize(contents.primitives.size());
  std::vector<double> leaving(contents.primitives.size(), 0);
  for (size_t i = 0; i < contents.edges.size(); ++i) {
    CheckEdge(contents.edges[i], i, contents.primitives);
    leaving[contents.edges[i].from] += contents.edges[i].model.probability;
    storage->out_edges[contents.edges[i].from].push_back(static_cast<int>(i));
  }
  for (const ActionChange& change : contents.changes) CheckChange(change, contents);
  for (size_t i = 0; i < leaving.size(); ++i) {
    Require(storage->out_edges[i].empty() || std::abs(leaving[i] - 1) < 1e-6,
            "chances of leaving primitive '" + contents.primitives[i].name + "' do not sum to 1");
  }
  for (MotionPrimitive& primitive : contents.primitives) boost::add_vertex(std::move(primitive), storage->graph);
  for (GraphEdge& edge : contents.edges) {
    storage->edges.push_back(boost::add_edge(edge.from, edge.to, std::move(edge.model), storage->graph).first);
  }
  contents.primitives.clear();
  contents.edges.clear();
  storage->header = std::move(contents);
  storage->hash = std::move(hash);
  storage_ = std::move(storage);
}

MotionGraph::~MotionGraph() = default;

const std::string& MotionGraph::name() const { return storage_->header.name; }
const std::string& MotionGraph::action() const { return storage_->header.action; }
const std::string& MotionGraph::hash() const { return storage_->hash; }
double MotionGraph::frame_rate_hz() const { return storage_->header.frame_rate_hz; }
const ModelProvenance& MotionGraph::provenance() const { return storage_->header.provenance; }
const PoseLayout& MotionGraph::layout() const { return storage_->header.layout; }
const Skeleton& MotionGraph::skeleton() const { return storage_->header.layout.skeleton(); }
const std::shared_ptr<const Skeleton>& MotionGraph::shared_skeleton() const {
  return storage_->header.layout.shared_skeleton();
}
const std::shared_ptr<const RecordedMotion>& MotionGraph::recordings() const { return storage_->header.recordings; }
const std::vector<ActionChange>& MotionGraph::changes() const { return storage_->header.changes; }
const std::vector<GraphStyle>& MotionGraph::styles() const { return storage_->header.styles; }

std::vector<std::string> MotionGraph::style_names(const std::string& action) const {
  std::vector<std::string> names;
  for (const GraphStyle& style : styles()) {
    if (!style.name.empty() && action_of(style) == action) names.push_back(style.name);
  }
  return names;
}

std::vector<std::string> MotionGraph::action_names() const {
  std::set<std::string> others;
  for (const GraphStyle& style : styles()) others.insert(action_of(style));
  others.erase(action());
  std::vector<std::string> names(others.begin(), others.end());
  names.insert(names.begin(), action());
  return names;
}

int MotionGraph::primitive_count() const { return static_cast<int>(boost::num_vertices(storage_->graph)); }
const MotionPrimitive& MotionGraph::primitive(int id) const { return storage_->graph[id]; }
int MotionGraph::edge_count() const { return static_cast<int>(storage_->edges.size()); }
int MotionGraph::edge_from(int id) const { return static_cast<int>(boost::source(storage_->edges.at(id), storage_->graph)); }
int MotionGraph::edge_to(int id) const { return static_cast<int>(boost::target(storage_->edges.at(id), storage_->graph)); }
const TransitionModel& MotionGraph::transition(int id) const { return storage_->graph[storage_->edges.at(id)]; }
const std::vector<int>& MotionGraph::out_edges(int primitive) const { return storage_->out_edges.at(primitive); }

}  // namespace morphograph
