#include "synthesis/control/foot_landings.h"

#include <algorithm>

namespace morphograph {
namespace {

constexpr double kFoot_m = 0.1;        // deviation of a foot that is put down, and more for every step until then
constexpr double kHalfWidth_m = 0.08;  // of a walk: feet from the way of the root
constexpr double kShortestContact_s = 0.12;  // that counts, see ContactOptions

// Whether a foot stays planted after the step's first key frame for long enough to count.
bool StandsOn(const ContactProfile& contacts, int side, double duration_s) {
  for (Eigen::Index s = 0; s < kPhaseSamples; ++s) {
    const double phase = PhaseOfSample(static_cast<int>(s));
    const double chance = std::max(contacts(kPlantedChance + 2 * side, s), contacts(kPlantedChance + 2 * side + 1, s));
    if (phase > 0 && chance < 0.5) return phase * duration_s > kShortestContact_s;
  }
  return true;
}

}  // namespace

int LandingFoot(const MotionPrimitive& primitive) {
  return primitive.end == KeyframeLabel::kLeftStance ? 0 : primitive.end == KeyframeLabel::kRightStance ? 1 : -1;
}

void CountFirstContacts(const MotionGraph& graph, const WalkGuide& guide, PlannedStep* first) {
  const MotionPrimitive& primitive = graph.primitive(first->step.primitive);
  const int lands = LandingFoot(primitive);
  if (guide.from != WalkBoundary::kWalking || lands < 0) {
    first->contacts[0] = first->contacts[1] = 1;
  } else {
    first->contacts[1 - lands] = 1;
    first->contacts[lands] = guide.counts_rear_foot.value_or(StandsOn(primitive.Contacts(first->step.latent), lands, primitive.Shape(first->step.latent).duration_s)) ? 1 : 0;
  }
  if (lands >= 0) ++first->contacts[lands];
}

void CountContacts(const MotionGraph& graph, const PlannedStep& before, PlannedStep* next) {
  std::copy(before.contacts, before.contacts + 2, next->contacts);
  if (const int lands = LandingFoot(graph.primitive(next->step.primitive)); lands >= 0) ++next->contacts[lands];
}

double Landing::deviation_m() const { return kFoot_m * (1 + 0.5 * steps); }

std::optional<Landing> LandingOf(const MotionGraph& graph, const FootPlace& foot, const PlannedStep& step, const Eigen::Vector2d& begin, const Eigen::Vector2d& end) {
  const int side = foot.left ? 0 : 1;
  const int landings = foot.index + 1 - step.contacts[side];
  const bool is_its_turn = LandingFoot(graph.primitive(step.step.primitive)) == side;  // that was over with this step
  if (landings < 0 || (landings == 0 && !is_its_turn)) return std::nullopt;
  const Eigen::Vector2d moved = end - begin;
  const double length = moved.norm();
  Landing landing;
  landing.steps = landings == 0 ? 0 : is_its_turn ? 2 * landings : 2 * landings - 1;
  // At a key frame the foot is half a step ahead of the root.
  landing.way_m = (landing.steps + 0.5) * moved;
  if (length > 1e-6) landing.way_m += (side == 0 ? 1 : -1) * kHalfWidth_m / length * Eigen::Vector2d(moved.y(), -moved.x());
  landing.position_m = end + landing.way_m;
  return landing;
}

}  // namespace morphograph
