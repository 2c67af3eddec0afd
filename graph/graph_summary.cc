#include "graph/graph_summary.h"

#include <array>
#include <cmath>

#include "graph/model_io.h"
#include "graph/motion_graph.h"

namespace morphograph {
namespace {

// Stretches of the canonical timeline where a part of a foot is planted more often than not.
std::vector<ContactSummary> SummariseContacts(const ContactProfile& profile) {
  static constexpr std::array<const char*, 4> kParts = {"left_heel", "left_ball", "right_heel", "right_ball"};
  std::vector<ContactSummary> contacts;
  for (int part = 0; part < 4; ++part) {
    for (int i = 0; i < kPhaseSamples; ++i) {
      if (profile(part, i) <= 0.5) continue;
      int last = i;
      while (last + 1 < kPhaseSamples && profile(part, last + 1) > 0.5) ++last;
      contacts.push_back({kParts[part], PhaseOfSample(i), PhaseOfSample(last)});
      i = last;
    }
  }
  return contacts;
}

// Duration at the mean latent of the mixture.
double MeanDuration(const MotionPrimitive& primitive) {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(primitive.reduction.components());
  for (const MixtureComponent& component : primitive.mixture.components()) {
    mean += std::exp(component.log_weight) * component.mean;
  }
  return primitive.Shape(mean).duration_s;
}

PrimitiveSummary SummarisePrimitive(const MotionGraph& graph, int id) {
  const MotionPrimitive& primitive = graph.primitive(id);
  PrimitiveSummary summary;
  summary.name = primitive.name;
  summary.style = primitive.style;
  summary.action = graph.action_of(graph.styles()[static_cast<size_t>(primitive.style_index)]);
  summary.start = primitive.start;
  summary.end = primitive.end;
  summary.examples = primitive.examples;
  summary.made_examples = primitive.made_examples;
  summary.components = primitive.reduction.components();
  summary.variance_kept = primitive.reduction.variance_kept;
  summary.mixture_size = primitive.mixture.size();
  summary.covariance_form = CovarianceFormName(primitive.covariance_form);
  summary.mean_duration_s = MeanDuration(primitive);
  summary.contacts = SummariseContacts(primitive.contacts);
  summary.dead_end = graph.is_dead_end(id);
  return summary;
}

}  // namespace

GraphSummary Summarise(const MotionGraph& graph) {
  GraphSummary summary;
  summary.name = graph.name();
  summary.hash = graph.hash();
  summary.action = graph.action();
  summary.format_version = FormatVersionOf(graph);
  summary.joints = graph.skeleton().joint_count();
  summary.frame_rate_hz = graph.frame_rate_hz();
  summary.metres_per_unit = graph.skeleton().metres_per_unit();
  const ModelProvenance& provenance = graph.provenance();
  summary.clips = provenance.clips;
  summary.frames = provenance.frames;
  summary.source = provenance.source;
  summary.licence = provenance.licence;
  summary.attribution = provenance.attribution;
  summary.command = provenance.command;
  summary.notes = provenance.notes;
  summary.styles = graph.style_names();
  for (const std::string& action : graph.action_names()) summary.actions.push_back({action, graph.style_names(action)});
  summary.boundaries = FindBoundaries(graph);
  for (int p = 0; p < graph.primitive_count(); ++p) summary.primitives.push_back(SummarisePrimitive(graph, p));
  for (int e = 0; e < graph.edge_count(); ++e) {
    const TransitionModel& model = graph.transition(e);
    summary.edges.push_back({graph.edge_from(e), graph.edge_to(e), model.pairs, model.probability, model.length_scale,
                             model.signal_variance, model.linear_variance, model.noise_variance, model.log_marginal_likelihood,
                             model.unseen_error});
  }
  for (const ActionChange& change : graph.changes()) {
    const PrimitiveSummary &from = summary.primitives[static_cast<size_t>(change.from)], &to = summary.primitives[static_cast<size_t>(change.to)];
    summary.changes.push_back({change.name, from.style, from.action, to.action, change.from, change.to, change.examples,
                               change.near_examples, change.least, change.captured});
  }
  return summary;
}

}  // namespace morphograph
