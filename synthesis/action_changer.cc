#include "synthesis/action_changer.h"

#include <limits>

namespace morphograph {
namespace {

constexpr int kStepsBefore = 12;  // drawn of the old action, to go on from the walk so far
constexpr int kStepsAfter = 48;   // drawn of the new one

}  // namespace

const std::vector<ActionChanger::Candidate>& ActionChanger::CandidatesOf(int primitive) {
  std::vector<Candidate>& drawn = candidates_[primitive];
  while (static_cast<int>(drawn.size()) < kStepsAfter) {
    WalkStep step = DrawFirstStep(graph_, primitive, rng_);
    StepShape shape = graph_.primitive(primitive).Shape(step.latent);
    drawn.push_back({std::move(step), std::move(shape)});
  }
  return drawn;
}

std::optional<ChangeTry> ActionChanger::Try(const WalkStep& previous, int style) {
  for (const int edge : graph_.out_edges(previous.primitive)) {
    for (size_t c = 0; c < graph_.changes().size(); ++c) {
      const ActionChange& change = graph_.changes()[c];
      const MotionPrimitive &from = graph_.primitive(change.from), &to = graph_.primitive(change.to);
      if (change.from != graph_.edge_to(edge) || to.style_index != style) continue;
      const MeanRotations& means = graph_.styles()[static_cast<size_t>(style)].mean_rotations;
      const Eigen::VectorXd weights = graph_.layout().ChannelWeights(means);
      Candidate before;
      const Candidate* after = nullptr;
      double nearest_m = std::numeric_limits<double>::max();
      for (int i = 0; i < kStepsBefore; ++i) {
        Candidate drawn;
        drawn.step = DrawNextStep(graph_, previous, edge, rng_);
        drawn.shape = from.Shape(drawn.step.latent);
        const Candidate* nearest = nullptr;
        for (const Candidate& candidate : CandidatesOf(change.to)) {
          const double apart_m = ChangeDistance_m(drawn.shape, candidate.shape, weights);
          if (apart_m >= nearest_m) continue;
          nearest = &candidate;
          nearest_m = apart_m;
        }
        if (!nearest) continue;
        after = nearest;
        before = std::move(drawn);
      }
      const Foot stance = from.start == KeyframeLabel::kLeftStance ? Foot::kLeft : Foot::kRight;
      StepWithContacts made = BlendSteps(graph_.layout(), means, stance, {before.shape, from.Contacts(before.step.latent)},
                                         {after->shape, to.Contacts(after->step.latent)});
      if (!IsWithin(EffortOf(before.shape, made.shape, after->shape, weights), change.captured)) return ChangeTry{std::move(before.step), {}};
      ChangeTry changed{after->step, std::move(made)};
      changed.step.edge = edge;
      changed.step.change = static_cast<int>(c);
      changed.step.log_likelihood = before.step.log_likelihood;
      return changed;
    }
  }
  return std::nullopt;
}

}  // namespace morphograph
