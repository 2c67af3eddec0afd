#include "synthesis/sensors/step_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "primitives/matrix_factors.h"


namespace morphograph {
namespace {

constexpr int kComponents = 24;
constexpr Eigen::Index kStepsOfBasis = 1000;
constexpr int kNearest = 4;
// A step of another length costs as if every reading were off by this for each unit of the log of their ratio (m/s^2).
constexpr double kLengthCost = 10;
// Steps whose length differs by more (in the log) are not looked at: that alone would cost 9 (m/s^2)^2, more than steps that fit.
constexpr float kWidestLength = 0.3F;

// Readings between frames; before the first and behind the last, those.
Eigen::VectorXf SamplesOf(const Eigen::MatrixXd& readings, double start, double frames) {
  Eigen::VectorXf samples(readings.rows() * kPhaseSamples);
  for (int i = 0; i < kPhaseSamples; ++i) {
    const double position = std::clamp(start + PhaseOfSample(i) * frames, 0.0, static_cast<double>(readings.cols() - 1));
    const Eigen::Index low = std::min<Eigen::Index>(static_cast<Eigen::Index>(position), std::max<Eigen::Index>(0, readings.cols() - 2));
    const Eigen::Index high = std::min(low + 1, readings.cols() - 1);
    const double t = position - static_cast<double>(low);
    samples.segment(i * readings.rows(), readings.rows()) = ((1 - t) * readings.col(low) + t * readings.col(high)).cast<float>();
  }
  return samples;
}

float LengthWeight(Eigen::Index values) { return static_cast<float>(kLengthCost * std::sqrt(static_cast<double>(values))); }

}  // namespace

StepSearch::StepSearch(const CapturedSteps& steps) : steps_(steps) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (int foot = 0; foot < 2; ++foot) {
    const StepBank& bank = steps.landing(foot == 0);
    Side& side = sides_[foot];
    if (bank.size() == 0) continue;
    const Eigen::Index values = bank.readings.rows();
    Eigen::MatrixXf vectors(values + 1, bank.size());
    vectors.topRows(values) = bank.readings;
    vectors.row(values) = LengthWeight(values) * bank.log_durations.transpose();
    side.mean = vectors.rowwise().mean();
    vectors.colwise() -= side.mean;
    const Eigen::Index stride = 1 + (bank.size() - 1) / kStepsOfBasis, used = 1 + (bank.size() - 1) / stride;
    Eigen::MatrixXd sample(values + 1, used);
    for (Eigen::Index i = 0; i < used; ++i) sample.col(i) = vectors.col(i * stride).cast<double>();
    const SymmetricFactors factors = FactorSymmetric(sample * sample.transpose());
    side.basis = factors.vectors.rightCols(std::min<Eigen::Index>(kComponents, values + 1)).cast<float>();
    std::vector<Eigen::Index> order(static_cast<std::size_t>(bank.size()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return bank.log_durations[a] < bank.log_durations[b]; });
    for (const Eigen::Index step : order) side.log_durations.push_back(bank.log_durations[step]);
    side.captured = (side.basis.transpose() * vectors)(Eigen::all, order);
    side.norms = side.captured.colwise().squaredNorm();
    least = std::min(least, std::exp(static_cast<double>(bank.log_durations.minCoeff())));
    most = std::max(most, std::exp(static_cast<double>(bank.log_durations.maxCoeff())));
  }
  // A little shorter and longer than any that was captured, for other tempos.
  shortest_ = std::max(4, static_cast<int>(std::floor(0.8 * least * kSensorRate_hz)));
  longest_ = std::max(shortest_ + 1, static_cast<int>(std::ceil(1.2 * most * kSensorRate_hz)));
}

Eigen::MatrixXf StepSearch::CostsAt(const Eigen::MatrixXd& readings, int start) const {
  const int lengths = longest_ - shortest_ + 1;
  const Eigen::Index values = readings.rows() * kPhaseSamples;
  Eigen::MatrixXf queries(values + 1, lengths);
  for (int n = 0; n < lengths; ++n) {
    queries.col(n).head(values) = SamplesOf(readings, start, shortest_ + n);
    queries(values, n) = LengthWeight(values) * static_cast<float>(std::log((shortest_ + n) / kSensorRate_hz));
  }
  Eigen::MatrixXf costs = Eigen::MatrixXf::Constant(lengths, 2, std::numeric_limits<float>::infinity());
  for (int foot = 0; foot < 2; ++foot) {
    const Side& side = sides_[foot];
    if (side.captured.cols() == 0) continue;
    const Eigen::MatrixXf centred = queries.colwise() - side.mean;
    const Eigen::MatrixXf projected = side.basis.transpose() * centred;
    const auto nearest = static_cast<std::ptrdiff_t>(std::min<Eigen::Index>(kNearest, side.captured.cols()));
    for (int n = 0; n < lengths; ++n) {
      // Steps about as long; a few at least.
      const auto log_length = static_cast<float>(std::log((shortest_ + n) / kSensorRate_hz));
      auto first = std::lower_bound(side.log_durations.begin(), side.log_durations.end(), log_length - kWidestLength);
      auto last = std::upper_bound(first, side.log_durations.end(), log_length + kWidestLength);
      while (last - first < nearest) {
        if (first != side.log_durations.begin()) --first;
        if (last != side.log_durations.end()) ++last;
      }
      const Eigen::Index from = first - side.log_durations.begin(), count = last - first;
      const Eigen::VectorXf distances = side.norms.segment(from, count) - 2 * (side.captured.middleCols(from, count).transpose() * projected.col(n));  // without the query's own norm
      float least[kNearest];
      std::fill_n(least, nearest, std::numeric_limits<float>::infinity());
      for (const float distance : distances) {
        if (distance >= least[nearest - 1]) continue;
        std::ptrdiff_t place = nearest - 1;
        for (; place > 0 && least[place - 1] > distance; --place) least[place] = least[place - 1];
        least[place] = distance;
      }
      const float mean = std::accumulate(least, least + nearest, 0.0F) / static_cast<float>(nearest);
      costs(n, foot) = std::max(0.0F, mean + centred.col(n).squaredNorm()) / static_cast<float>(values);
    }
  }
  return costs;
}

FoundStep StepSearch::PartialStep(const Eigen::MatrixXd& readings, double key_frame, double neighbour_frames, bool left, bool leading) const {
  const StepBank& bank = steps_.landing(left);
  const double inside = leading ? key_frame : static_cast<double>(readings.cols() - 1) - key_frame;  // frames there are of it
  FoundStep best;
  double least = std::numeric_limits<double>::infinity();
  for (int frames = shortest_; frames <= longest_; ++frames) {
    if (frames < inside) continue;
    const FoundStep step = leading ? FoundStep{key_frame - frames, key_frame, left} : FoundStep{key_frame, key_frame + frames, left};
    const Eigen::VectorXf samples = SamplesOf(readings, step.start_frame, frames);
    int first = kPhaseSamples, last = -1;  // samples inside the stream
    for (int i = 0; i < kPhaseSamples; ++i) {
      const double at = step.start_frame + PhaseOfSample(i) * frames;
      if (at >= 0 && at <= static_cast<double>(readings.cols() - 1)) first = std::min(first, i), last = i;
    }
    double cost = 0;
    if (last >= first && bank.size() > 0) {
      const Eigen::Index row = first * readings.rows(), rows = (last - first + 1) * readings.rows();
      cost = (bank.readings.middleRows(row, rows).colwise() - samples.segment(row, rows)).colwise().squaredNorm().minCoeff() / static_cast<double>(rows);
    }
    cost += std::pow(kLengthCost * std::log(frames / neighbour_frames), 2);
    if (cost < least) least = cost, best = step;
  }
  return best;
}

std::vector<FoundStep> StepSearch::Find(const Eigen::MatrixXd& readings) const {
  const int frames = static_cast<int>(readings.cols());
  if (frames <= shortest_) return {};
  const int lengths = longest_ - shortest_ + 1;
  // Cost of whole steps by their first frame.
  std::vector<Eigen::MatrixXf> costs;
  std::vector<double> typical;
  for (int start = 0; start + shortest_ < frames; ++start) {
    costs.push_back(CostsAt(readings, start));
    typical.push_back(costs.back().topRows(std::min(lengths, frames - start - shortest_)).minCoeff());
  }
  std::nth_element(typical.begin(), typical.begin() + static_cast<std::ptrdiff_t>(typical.size() / 2), typical.end());
  const double partial = typical[typical.size() / 2];

  struct Node {
    double cost = std::numeric_limits<double>::infinity();
    int length = 0;  // of the step that ends here; 0: the first key frame
  };
  std::vector<Node> nodes[2];  // by the foot that lands there
  for (auto& side : nodes) side.resize(static_cast<std::size_t>(frames));
  for (int frame = 0; frame < frames; ++frame) {
    for (int foot = 0; foot < 2; ++foot) {
      Node& node = nodes[foot][static_cast<std::size_t>(frame)];
      if (frame < longest_) node.cost = partial * frame;
      for (int length = shortest_; length <= std::min(longest_, frame); ++length) {
        const int start = frame - length;
        const double cost = nodes[1 - foot][static_cast<std::size_t>(start)].cost + length * static_cast<double>(costs[static_cast<std::size_t>(start)](length - shortest_, foot));
        if (cost < node.cost) node = {cost, length};
      }
    }
  }
  int frame = 0, foot = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int end = std::max(0, frames - longest_); end < frames; ++end) {
    for (int side = 0; side < 2; ++side) {
      const double cost = nodes[side][static_cast<std::size_t>(end)].cost + partial * (frames - 1 - end);
      if (cost < least) least = cost, frame = end, foot = side;
    }
  }
  const int last_key_frame = frame;
  const bool last_left = foot == 0;
  std::vector<FoundStep> found;
  while (nodes[foot][static_cast<std::size_t>(frame)].length > 0) {
    const int length = nodes[foot][static_cast<std::size_t>(frame)].length;
    found.push_back({static_cast<double>(frame - length), static_cast<double>(frame), foot == 0});
    frame -= length;
    foot = 1 - foot;
  }
  std::reverse(found.begin(), found.end());
  const double middle = (shortest_ + longest_) / 2.0;
  const double next = found.empty() ? middle : found.front().frames(), before = found.empty() ? middle : found.back().frames();
  if (frame > 0) found.insert(found.begin(), PartialStep(readings, frame, next, foot == 0, true));
  if (last_key_frame < frames - 1) found.push_back(PartialStep(readings, last_key_frame, before, !last_left, false));
  return found;
}

}  // namespace morphograph
