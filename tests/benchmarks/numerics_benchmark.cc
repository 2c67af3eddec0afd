// Speed of the numeric pieces over swept sizes, on seeded random data. Times are wall clock of one thread.

#include <benchmark/benchmark.h>

#include <cmath>

#include "graph/gaussian_process.h"
#include "primitives/cubic_resample.h"
#include "primitives/frame_distance.h"
#include "primitives/gaussian_mixture.h"
#include "primitives/rotation_math.h"
#include "primitives/time_warp.h"
#include "primitives/weighted_pca.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using testing::RandomNormal;
using testing::RandomRotation;

// Poses that drift from frame to frame, as those of a step do.
std::vector<Eigen::Matrix3Xd> Frames(int frames, int joints, std::mt19937_64& rng) {
  std::vector<Eigen::Matrix3Xd> out = {RandomNormal(3, joints, rng)};
  while (static_cast<int>(out.size()) < frames) out.push_back(out.back() + 0.1 * RandomNormal(3, joints, rng));
  return out;
}

// Latents of decaying spread about three means, correlated inside each.
Eigen::MatrixXd Latents(int dimension, int count, std::mt19937_64& rng) {
  Eigen::MatrixXd mix = RandomNormal(dimension, dimension, rng) / std::sqrt(dimension);
  mix.diagonal().array() += 1;
  Eigen::MatrixXd out = mix * RandomNormal(dimension, count, rng);
  for (int i = 0; i < count; ++i) out(i % 3 % dimension, i) += 4;
  return out;
}

void BM_ExpMap(benchmark::State& state) {
  std::mt19937_64 rng(1);
  const Eigen::MatrixXd vectors = 0.5 * RandomNormal(3, 6600, rng);  // 300 frames of 22 joints
  for (auto _ : state)
    for (int i = 0; i < vectors.cols(); ++i) benchmark::DoNotOptimize(ExpMap(vectors.col(i)).coeffs().data());
  state.SetItemsProcessed(state.iterations() * vectors.cols());
}
BENCHMARK(BM_ExpMap)->Unit(benchmark::kMicrosecond);

void BM_GeodesicMean(benchmark::State& state) {
  std::mt19937_64 rng(1);
  const Eigen::Quaterniond centre = RandomRotation(rng);
  std::vector<Eigen::Quaterniond> rotations;
  for (int i = 0; i < state.range(0); ++i) rotations.push_back(ExpMapAbout(centre, 0.3 * RandomNormal(3, 1, rng)));
  for (auto _ : state) benchmark::DoNotOptimize(GeodesicMean(rotations));
}
BENCHMARK(BM_GeodesicMean)->Arg(100)->Arg(10000)->Unit(benchmark::kMicrosecond);

void BM_SplineWeights(benchmark::State& state) {
  std::mt19937_64 rng(1);
  const UniformCubicSpline spline(25);
  const Eigen::MatrixXd data = RandomNormal(state.range(0), 25, rng);
  const Eigen::VectorXd positions = Eigen::VectorXd::LinSpaced(20, 0.3, 23.9);
  for (auto _ : state) benchmark::DoNotOptimize((data * spline.Weights(positions)).eval().data());
}
BENCHMARK(BM_SplineWeights)->Arg(1)->Arg(70)->Unit(benchmark::kMicrosecond);

void BM_ResampleCubic(benchmark::State& state) {
  std::mt19937_64 rng(1);
  const Eigen::MatrixXd data = RandomNormal(70, state.range(0), rng);
  const Eigen::VectorXd positions = Eigen::VectorXd::LinSpaced(25, 50.3, 74.9);
  for (auto _ : state) benchmark::DoNotOptimize(ResampleCubic(data, positions).data());
}
BENCHMARK(BM_ResampleCubic)->Arg(100)->Arg(1000)->Unit(benchmark::kMicrosecond);

void BM_FrameDistance(benchmark::State& state) {  // consecutive frames of a clip, for naturalness
  std::mt19937_64 rng(1);
  const int joints = 22;
  const std::vector<Eigen::Matrix3Xd> frames = Frames(static_cast<int>(state.range(0)), joints, rng);
  const Eigen::VectorXd weights = Eigen::VectorXd::Constant(joints, 1.0 / joints);
  for (auto _ : state)
    for (std::size_t i = 1; i < frames.size(); ++i) benchmark::DoNotOptimize(FrameDistance(frames[i - 1], frames[i], weights));
}
BENCHMARK(BM_FrameDistance)->Arg(300)->Unit(benchmark::kMicrosecond);

void BM_AlignSegment(benchmark::State& state) {  // distances, time warping and the smooth fit of one segment
  std::mt19937_64 rng(1);
  const auto frames = static_cast<int>(state.range(0));
  const std::vector<Eigen::Matrix3Xd> reference = Frames(18, 22, rng), test = Frames(frames, 22, rng);
  const Eigen::VectorXd weights = Eigen::VectorXd::Constant(22, 1.0 / 22);
  for (auto _ : state) {
    const WarpPath path = DynamicTimeWarp(FrameDistanceMatrix(reference, test, weights));
    benchmark::DoNotOptimize(TimeWarp::Fit(path, 18, frames, 5, 1e-3).log_slopes().data());
  }
}
BENCHMARK(BM_AlignSegment)->Arg(16)->Arg(20)->Arg(60)->Unit(benchmark::kMicrosecond);

void BM_WeightedPca(benchmark::State& state) {
  std::mt19937_64 rng(1);
  const Eigen::MatrixXd samples = RandomNormal(state.range(0), 60, rng) * RandomNormal(60, state.range(1), rng) +
                                  0.01 * RandomNormal(state.range(0), state.range(1), rng);
  const Eigen::VectorXd weights = RandomNormal(state.range(0), 1, rng).cwiseAbs();
  int components = 0;
  for (auto _ : state) components = FitWeightedPca(samples, weights).components();
  state.counters["components"] = components;
}
BENCHMARK(BM_WeightedPca)->Args({1800, 100})->Args({1800, 400})->Unit(benchmark::kMillisecond);

void BM_SelectGaussianMixture(benchmark::State& state) {
  std::mt19937_64 rng(1);
  const Eigen::MatrixXd samples = Latents(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), rng);
  int size = 0;
  for (auto _ : state) {
    std::mt19937_64 starts(1);
    size = SelectGaussianMixture(samples, {}, starts).best.mixture.size();
  }
  state.counters["components"] = size;
}
BENCHMARK(BM_SelectGaussianMixture)->Args({20, 400})->Args({50, 400})->Args({70, 1000})->Unit(benchmark::kMillisecond);

struct Pairs {
  Eigen::MatrixXd inputs, outputs;
};

Pairs MakePairs(int dimension, int count) {
  std::mt19937_64 rng(1);
  Pairs out;
  out.inputs = Latents(dimension, count, rng);
  out.outputs = (RandomNormal(dimension, dimension, rng) / std::sqrt(dimension) * out.inputs).array().sin();
  out.outputs += 0.5 * RandomNormal(dimension, count, rng);
  return out;
}

void BM_FitGaussianProcess(benchmark::State& state) {
  const Pairs pairs = MakePairs(50, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(GaussianProcess::Fit(pairs.inputs, pairs.outputs).alpha().data());
}
BENCHMARK(BM_FitGaussianProcess)->Arg(100)->Arg(400)->Arg(1000)->Unit(benchmark::kMillisecond);

void BM_FitInducingPoints(benchmark::State& state) {
  const Pairs pairs = MakePairs(50, static_cast<int>(state.range(0)));
  const GaussianProcessKernel kernel{1, 10, 0, 0.3};
  for (auto _ : state)
    benchmark::DoNotOptimize(GaussianProcess::Condition(kernel, pairs.inputs, pairs.outputs).alpha().data());
}
BENCHMARK(BM_FitInducingPoints)->Arg(2001)->Arg(4000)->Unit(benchmark::kMillisecond);

void BM_PredictMean(benchmark::State& state) {
  const Pairs pairs = MakePairs(50, static_cast<int>(state.range(0)));
  const GaussianProcess process = GaussianProcess::Condition({1, 10, 0, 0.3}, pairs.inputs, pairs.outputs);
  const Eigen::VectorXd at = pairs.inputs.col(7) * 0.9;
  for (auto _ : state) benchmark::DoNotOptimize(process.PredictMean(at).data());
}
BENCHMARK(BM_PredictMean)->Arg(100)->Arg(400)->Unit(benchmark::kMicrosecond);

void BM_PredictWithVariance(benchmark::State& state) {
  const Pairs pairs = MakePairs(50, static_cast<int>(state.range(0)));
  const GaussianProcess process = GaussianProcess::Condition({1, 10, 0, 0.3}, pairs.inputs, pairs.outputs);
  const Eigen::VectorXd at = pairs.inputs.col(7) * 0.9;
  for (auto _ : state) benchmark::DoNotOptimize(process.Predict(at).variance);
}
BENCHMARK(BM_PredictWithVariance)->Arg(100)->Arg(400)->Unit(benchmark::kMicrosecond);

void BM_RebuildGaussianProcess(benchmark::State& state) {  // as reading a model does
  const Pairs pairs = MakePairs(50, 400);
  const GaussianProcess process = GaussianProcess::Condition({1, 10, 0, 0.3}, pairs.inputs, pairs.outputs);
  for (auto _ : state)
    benchmark::DoNotOptimize(GaussianProcess(process.kernel(), process.inputs(), process.alpha(), 0).points());
}
BENCHMARK(BM_RebuildGaussianProcess)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace morphograph
