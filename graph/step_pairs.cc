#include "graph/step_pairs.h"

#include <map>
#include <utility>

namespace morphograph {

std::vector<StepPairs> FindStepPairs(const TrainingSet& set) {
  // Every step's class and place in it; -1 where its class was left out.
  struct Membership {
    int group = -1;
    int column = 0;
  };
  std::vector<Membership> place(set.steps.size());
  for (size_t c = 0; c < set.classes.size(); ++c) {
    for (size_t m = 0; m < set.classes[c].members.size(); ++m) {
      place[set.classes[c].members[m]] = {static_cast<int>(c), static_cast<int>(m)};
    }
  }
  std::map<std::pair<int, int>, StepPairs> pairs;
  for (size_t i = 0; i < set.steps.size(); ++i) {
    if (set.steps[i].previous < 0) continue;
    const TrainingStep& before = set.steps[set.steps[i].previous];
    const Membership from = place[set.steps[i].previous];
    const Membership to = place[i];
    if (from.group < 0 || to.group < 0) continue;
    const bool both_walk = IsWalkStep(set.steps[i]) && IsWalkStep(before);
    if (both_walk && !(set.steps[i].steady && before.steady)) continue;
    StepPairs& list = pairs[{from.group, to.group}];
    list.from = from.group;
    list.to = to.group;
    list.previous.push_back(from.column);
    list.next.push_back(to.column);
    list.source.push_back(set.clips[set.steps[i].clip].source);
    list.made.push_back(set.clips[set.steps[i].clip].made);
  }
  std::vector<StepPairs> sorted;
  for (auto& [ends, list] : pairs) sorted.push_back(std::move(list));
  return sorted;
}

TransitionPairs LatentsOf(const StepPairs& pairs, const Eigen::MatrixXd& from, const Eigen::MatrixXd& to) {
  return {from(Eigen::all, pairs.previous), to(Eigen::all, pairs.next), pairs.source, pairs.made};
}

}  // namespace morphograph
