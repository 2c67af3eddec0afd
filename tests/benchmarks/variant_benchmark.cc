// Many clips of one request: what they cost, and whether their steps differ as captured ones of the style do.
//
//   variant_benchmark --model bnr.mgm --data CAPTURED… [--count 100] [--threads 2]
//
// Steps of both go from landing to landing, found by the same detector, at ten phases and seen from the body; those of the other foot are
// compared with their own kind. The request is a straight line of 8 m, since captured walks are straight.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "datasets/dataset_loader.h"
#include "graph/model_io.h"
#include "primitives/keyframe_detector.h"
#include "synthesis/joint_spread.h"
#include "synthesis/variant_set.h"

namespace {

using morphograph::JointSamples;
using morphograph::KeyframeLabel;
using morphograph::MotionClip;
using StepsByFoot = std::map<KeyframeLabel, std::vector<JointSamples>>;

constexpr std::size_t kMostSteps = 400;  // of a foot

void AddSteps(const MotionClip& clip, StepsByFoot* steps) {
  const auto landings = morphograph::DetectKeyframes(clip);
  // The first and the last step of a clip may be cut.
  for (std::size_t i = 1; i + 2 < landings.size(); ++i) {
    const int from = static_cast<int>(std::lround(landings[i].frame)), to = static_cast<int>(std::lround(landings[i + 1].frame));
    const bool is_step = landings[i].label != landings[i + 1].label && landings[i].label <= KeyframeLabel::kRightStance &&
                         landings[i + 1].label <= KeyframeLabel::kRightStance;
    if (is_step && to > from)
      (*steps)[landings[i].label].push_back(morphograph::SampleJoints(clip, from, to, 10, morphograph::SampleFrame::kBody));
  }
}

double Spread_m(const StepsByFoot& steps) {
  double sum = 0;
  for (const auto& [foot, all] : steps) {
    std::vector<JointSamples> picked;
    const std::size_t count = std::min(all.size(), kMostSteps);
    for (std::size_t i = 0; i < count; ++i) picked.push_back(all[i * all.size() / count]);
    sum += morphograph::MeanPairwiseJointDistance(picked);
  }
  return steps.empty() ? 0 : sum / static_cast<double>(steps.size());
}

double CpuTime_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int argc, char** argv) {
  std::string model;
  std::vector<std::filesystem::path> data;
  morphograph::VariantOptions options;
  options.count = 100;
  options.threads = 2;
  CLI::App app("Variants of one request");
  app.add_option("--model", model, "model file")->required();
  app.add_option("--data", data, "captured BVH files and folders")->required();
  app.add_option("--count", options.count, "variants a style");
  app.add_option("--threads", options.threads, "threads");
  CLI11_PARSE(app, argc, argv);

  const auto graph = morphograph::LoadModel(model);
  std::map<std::string, StepsByFoot> captured;
  for (const morphograph::LoadedClip& loaded : morphograph::LoadDataset(data).clips) AddSteps(loaded.clip, &captured[loaded.clip.style]);

  std::printf("%-12s %6s %8s %8s %8s %10s %10s %8s %10s\n", "style", "made", "wall s", "cpu s", "steps", "spread cm", "captured", "ratio",
              "swept m2");
  for (const std::string& style : graph->style_names()) {
    morphograph::SynthesisRequest request;
    request.seed = 1;
    request.style = style;
    request.control.path.emplace().points_m = {{0, 0}, {0, 8}};
    const auto started = std::chrono::steady_clock::now();
    const double cpu_s = CpuTime_s();
    const morphograph::VariantSet set = morphograph::MakeVariants(*graph, request, options);
    const double used_s = CpuTime_s() - cpu_s;
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - started;
    StepsByFoot steps;
    std::size_t count = 0;
    for (const morphograph::ClipVariant& variant : set.variants) AddSteps(variant.clip, &steps);
    for (const auto& [foot, all] : steps) count += all.size();
    const double made_m = Spread_m(steps), captured_m = Spread_m(captured[style]);
    std::printf("%-12s %6d %8.2f %8.2f %8zu %10.2f %10.2f %8.2f %10.2f\n", style.c_str(), set.summary.made, wall.count(), used_s, count,
                100 * made_m, 100 * captured_m, captured_m > 0 ? made_m / captured_m : 0, set.summary.swept_area.area_m2);
  }
  return 0;
}
