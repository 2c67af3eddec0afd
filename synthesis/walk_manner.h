#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "graph/motion_graph.h"

namespace morphograph {

/// The manner of a walk under way, by primitive id; empty vectors for primitives of other styles and for those without a manner.
struct WalkManner {
  std::vector<Eigen::VectorXd> m;           // of MannerModel
  std::vector<Eigen::VectorXd> met;         // how often it meets each mixture component; empty: as often as all walks
  std::vector<Eigen::VectorXd> components;  // factors on the chances of entering them; empty: all 1
};

/// How often a captured walk's manner is met: at a step drawn from all steps, or at a time drawn from all time. Slow walks hold more
/// time than steps. A clip begins at some time; the manner of a walk that goes on changes step by step.
enum class MetAt { kStep, kTime };

/// Draws a manner: that of a captured walk of the style, as far as it is known, and noise for what is not. So what goes together in a
/// captured walk goes together here.
WalkManner DrawManner(const MotionGraph& graph, int style, MetAt met, std::mt19937_64& rng);

/// Lets a walk of that manner meet the mixture components of every primitive about as often as all walks together do, however far it goes.
void FreeComponents(WalkManner* manner);
/// Whether it does.
bool IsFree(const WalkManner& manner);

/// The manner a step later. m drifts slowly, among those of walks that keep to the same mixture components, and keeps its variance; now and then the components become those of another such
/// walk. Over many steps captured walks are met by their steps.
void DriftManner(const MotionGraph& graph, int style, std::mt19937_64& rng, WalkManner* manner);

}  // namespace morphograph
