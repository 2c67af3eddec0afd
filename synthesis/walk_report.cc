#include "synthesis/walk_report.h"

#include <algorithm>
#include <cmath>

namespace morphograph {
namespace {

std::vector<StepReport> ReportSteps(const MotionGraph& graph, const std::vector<DrawnStep>& walk, int frames) {
  std::vector<StepReport> steps;
  for (const DrawnStep& drawn : walk) {
    // The margins in which a walk starts and ends belong to its first and its last step.
    const int from = steps.empty() ? 0 : static_cast<int>(std::ceil(drawn.start));
    if (from >= frames) break;
    const int to = &drawn == &walk.back() ? frames - 1 : std::min(frames - 1, static_cast<int>(std::ceil(drawn.end)) - 1);
    const int change = drawn.step.change;
    const std::string& name =
        change < 0 ? graph.primitive(drawn.step.primitive).name : graph.changes()[static_cast<std::size_t>(change)].name;
    steps.push_back({name, from, std::max(from, to), drawn.step.log_likelihood});
  }
  return steps;
}

// What a walk shows, from its first step and from each made step on; empty where it never changes.
std::vector<ActionSpan> ReportActions(const MotionGraph& graph, const DrawnWalk& walk, const std::vector<StepReport>& steps) {
  std::vector<ActionSpan> spans;
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const WalkStep& step = walk.steps[s].step;
    const int style = graph.primitive(step.primitive).style_index;
    if (s == 0 || step.change >= 0) spans.push_back({graph.action_of(graph.styles()[static_cast<std::size_t>(style)]), steps[s].from});
  }
  if (spans.size() < 2) spans.clear();
  return spans;
}

}  // namespace

SynthesisReport DescribeWalk(const MotionGraph& graph, const DrawnWalk& walk, const MotionClip& clip, const ClipEvaluation* evaluation) {
  SynthesisReport report;
  report.model_name = graph.name();
  report.model_hash = graph.hash();
  if (!walk.steps.empty()) {
    const int style = graph.primitive(walk.steps.front().step.primitive).style_index;
    report.action = graph.action_of(graph.styles()[static_cast<std::size_t>(style)]);
  }
  report.style = clip.style;
  report.frames = walk.frames;
  report.duration_s = clip.duration_s();
  report.steps = ReportSteps(graph, walk.steps, walk.frames);
  report.actions = ReportActions(graph, walk, report.steps);
  for (int f = 0; f < walk.frames; ++f) {
    const Eigen::Vector3d root = clip.root_positions().col(f);
    report.path_m.emplace_back(root.x(), root.z());
  }
  if (walk.frames >= 2) {
    const ClipEvaluation evaluated = evaluation ? *evaluation : EvaluateClip(clip);
    report.contacts = evaluated.contacts;
    report.quality = evaluated.quality;
  }
  double log_likelihood = 0;
  for (const StepReport& step : report.steps) log_likelihood += step.log_likelihood;
  report.quality.log_likelihood = log_likelihood;
  return report;
}

}  // namespace morphograph
