// Reading and writing of BVH: a 10 s clip of 22 joints, and with the recordings at hand the whole set (MB/s and the
// worst error of read -> import -> export -> write -> read -> import, in metres).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include "datasets/bvh_reader.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/dataset_loader.h"
#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

// 22 joints in a row, 300 frames at 30 Hz: 69 channels in the portable form.
MotionClip TenSeconds() {
  std::vector<Joint> joints(22);
  for (int j = 0; j < 22; ++j) {
    joints[j].name = "joint" + std::to_string(j);
    joints[j].parent = j - 1;
    joints[j].offset_m = Eigen::Vector3d(0.08, 0.01 * j, 0);
  }
  MotionClip clip(std::make_shared<const Skeleton>(joints, RoleMap(), 0.01, UpAxis::kY), 30, 300);
  for (int f = 0; f < 300; ++f) {
    clip.root_positions().col(f) = Eigen::Vector3d(0.01 * f, 0.9 + 0.02 * std::sin(0.4 * f), 0.03 * f);
    for (int j = 0; j < 22; ++j) {
      clip.rotation(f, j) = Eigen::AngleAxisd(std::sin(0.2 * f + j), Eigen::Vector3d(1, 0.3 * j, -0.5).normalized());
    }
  }
  return clip;
}

void ExportTenSeconds(benchmark::State& state) {
  const MotionClip clip = TenSeconds();
  for (auto _ : state) benchmark::DoNotOptimize(ExportClip(clip));
}
BENCHMARK(ExportTenSeconds)->Unit(benchmark::kMillisecond);

void WriteTenSeconds(benchmark::State& state) {
  const BvhDocument document = ExportClip(TenSeconds());
  std::int64_t bytes = 0;
  for (auto _ : state) bytes += static_cast<std::int64_t>(WriteBvh(document).size());
  state.SetBytesProcessed(bytes);
}
BENCHMARK(WriteTenSeconds)->Unit(benchmark::kMillisecond);

void ParseTenSeconds(benchmark::State& state) {
  const std::string text = WriteBvh(ExportClip(TenSeconds()));
  for (auto _ : state) benchmark::DoNotOptimize(ParseBvh(text, "clip"));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}
BENCHMARK(ParseTenSeconds)->Unit(benchmark::kMillisecond);

void ImportTenSeconds(benchmark::State& state) {
  const BvhDocument document = ExportClip(TenSeconds());
  for (auto _ : state) benchmark::DoNotOptimize(ImportClip(document));
}
BENCHMARK(ImportTenSeconds)->Unit(benchmark::kMillisecond);

std::filesystem::path Recordings() {
  if (const char* given = std::getenv("MORPHOGRAPH_DATA"); given && *given) return given;
  return std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / ".." / "shared" / "data";
}

double WorstDistance(const MotionClip& a, const MotionClip& b) {
  const std::vector<Eigen::Matrix3Xd> one = JointPositions(a), other = JointPositions(b);
  double worst = one.size() == other.size() ? 0 : INFINITY;
  for (size_t f = 0; f < std::min(one.size(), other.size()); ++f) {
    worst = std::max(worst, (one[f] - other[f]).cwiseAbs().maxCoeff());
  }
  return worst;
}

void RoundTripOfEveryRecording(benchmark::State& state) {
  if (!std::filesystem::exists(Recordings())) {
    state.SkipWithError("set MORPHOGRAPH_DATA to the folder of the recordings");
    return;
  }
  const std::vector<std::filesystem::path> files = FindBvhFiles({Recordings()});
  double worst_value = 0, worst_position_m = 0;
  std::int64_t bytes = 0;
  for (auto _ : state) {
    for (const std::filesystem::path& file : files) {
      std::ifstream stream(file, std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
      bytes += static_cast<std::int64_t>(text.size());
      const BvhDocument document = ParseBvh(text, file.string());
      const BvhDocument again = ParseBvh(WriteBvh(document), file.string());
      worst_value = std::max(worst_value, (document.values - again.values).cwiseAbs().maxCoeff());
      ClipImportReport report;
      const MotionClip clip = ImportClip(document, ClipImportOptions(), &report);
      ClipImportOptions same;
      same.metres_per_unit = report.metres_per_unit;
      same.up_axis = report.up_axis;
      same.drop_leading_rest = false;
      const MotionClip back = ImportClip(ParseBvh(WriteBvh(ExportClip(clip)), file.string()), same);
      worst_position_m = std::max(worst_position_m, WorstDistance(clip, back));
    }
  }
  state.SetBytesProcessed(bytes);
  state.counters["clips"] = static_cast<double>(files.size());
  state.counters["worst_value"] = worst_value;
  state.counters["worst_position_m"] = worst_position_m;
}
BENCHMARK(RoundTripOfEveryRecording)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace morphograph
