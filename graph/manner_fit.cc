#include "graph/manner_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "primitives/whitening.h"

namespace morphograph {
namespace {

struct LaggedCovariance {
  Eigen::ArrayXd mean, error;  // of the products of two steps, per value, and its standard error
  int pairs = 0;
};

// Over all pairs of steps of one walk that are at least `fewest` steps apart.
LaggedCovariance CovarianceApart(const MannerSteps& steps, const std::vector<std::vector<int>>& of_walk, int fewest) {
  const Eigen::Index dims = steps.whitened.rows();
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(dims), squares = sum;
  LaggedCovariance result;
  for (const std::vector<int>& members : of_walk) {
    for (size_t i = 0; i < members.size(); ++i) {
      for (size_t j = 0; j < i; ++j) {
        if (std::abs(steps.ordinal[members[i]] - steps.ordinal[members[j]]) < fewest) continue;
        const Eigen::ArrayXd product = steps.whitened.col(members[i]).array() * steps.whitened.col(members[j]).array();
        sum += product;
        squares += product.square();
        ++result.pairs;
      }
    }
  }
  const double count = std::max(1, result.pairs);
  result.mean = sum / count;
  result.error = ((squares / count - result.mean.square()).max(0) / count).sqrt();
  return result;
}

// From the whitened steps of one walk.
Eigen::VectorXd PredictManner(const Eigen::VectorXd& share, const Eigen::MatrixXd& steps) {
  const Eigen::ArrayXd b = share.array(), mean = steps.rowwise().mean().array();
  return (b > 0).select(b / (b + (1 - b) / static_cast<double>(steps.cols())) * mean, 0);
}

}  // namespace

MannerModel FitManner(const MannerSteps& steps, const MannerFitOptions& options) {
  const size_t count = static_cast<size_t>(steps.whitened.cols());
  if (steps.walk.size() != count || steps.ordinal.size() != count || steps.seconds.size() != count ||
      steps.component.size() != count) {
    throw std::invalid_argument("FitManner: needs component, walk, number and duration of every step");
  }
  std::vector<std::vector<int>> of_walk(static_cast<size_t>(std::max(0, steps.walks)));
  for (size_t i = 0; i < count; ++i) of_walk.at(static_cast<size_t>(steps.walk[i])).push_back(static_cast<int>(i));

  LaggedCovariance apart = CovarianceApart(steps, of_walk, options.far_steps);
  if (apart.pairs < options.fewest_far_pairs) apart = CovarianceApart(steps, of_walk, options.near_steps);
  if (apart.pairs < options.fewest_pairs) return {};
  MannerModel manner;
  manner.share = (apart.mean > 2 * apart.error).select(apart.mean, 0).min(options.largest_share);

  manner.captured = Eigen::MatrixXf::Zero(steps.whitened.rows(), steps.walks);
  manner.components = Eigen::MatrixXf::Ones(steps.component_weights.size(), steps.walks);
  manner.met = steps.component_weights.cast<float>().replicate(1, steps.walks);
  for (int walk = 0; walk < steps.walks; ++walk) {
    const std::vector<int>& members = of_walk[static_cast<size_t>(walk)];
    manner.steps.push_back(static_cast<int>(members.size()));
    double seconds = 0;
    for (const int i : members) seconds += steps.seconds[static_cast<size_t>(i)];
    manner.seconds.push_back(static_cast<float>(seconds));
    if (!members.empty()) {
      manner.captured.col(walk) = PredictManner(manner.share, steps.whitened(Eigen::all, members)).cast<float>();
      // Counts and, worth a hundredth of a step, what all walks do: where walks keep to a component, drawn ones must too, as a manner
      // is told in the coordinates of its component.
      Eigen::VectorXd met = 0.01 * steps.component_weights;
      for (const int i : members) met[steps.component[static_cast<size_t>(i)]] += 1;
      manner.met.col(walk) = (met / met.sum()).cast<float>();
      manner.components.col(walk) = manner.met.col(walk).cwiseQuotient(steps.component_weights.cast<float>());
    }
  }
  return manner;
}

namespace {

// A walk's manner is drawn by the steps of all primitives of its style, and must not move the mean of any of them.
void CentreManners(std::vector<FittedPrimitive>* fitted) {
  std::map<int, Eigen::VectorXd> weights;  // per style: steps of every walk
  for (const FittedPrimitive& f : *fitted) {
    const MannerModel& manner = f.primitive.manner;
    if (manner.empty()) continue;
    Eigen::VectorXd& of_style = weights.try_emplace(f.primitive.style_index, Eigen::VectorXd::Zero(manner.walks())).first->second;
    of_style += Eigen::Map<const Eigen::VectorXi>(manner.steps.data(), manner.walks()).cast<double>();
  }
  for (FittedPrimitive& f : *fitted) {
    MannerModel& manner = f.primitive.manner;
    if (manner.empty()) continue;
    const Eigen::VectorXd known = (Eigen::Map<const Eigen::VectorXi>(manner.steps.data(), manner.walks()).array() > 0).cast<double>();
    const Eigen::VectorXd shares = weights.at(f.primitive.style_index).cwiseProduct(known);
    const Eigen::VectorXd centre = manner.captured.cast<double>() * shares / shares.sum();
    manner.captured -= centre.cast<float>() * known.cast<float>().transpose();
    f.manners.colwise() -= centre;
  }
}

// Steady steps of a class by clip, whitened.
std::map<int, std::vector<int>> SteadyByClip(const TrainingSet& set, const StepClass& members) {
  std::map<int, std::vector<int>> places;
  for (size_t m = 0; m < members.members.size(); ++m) {
    const TrainingStep& step = set.steps[members.members[m]];
    if (step.steady) places[step.clip].push_back(static_cast<int>(m));
  }
  return places;
}

}  // namespace

void FitManners(const TrainingSet& set, std::vector<FittedPrimitive>* fitted) {
  std::vector<int> ordinals(set.steps.size(), 0);  // number of each step in its walk
  for (size_t i = 0; i < set.steps.size(); ++i) {
    if (set.steps[i].previous >= 0) ordinals[i] = ordinals[static_cast<size_t>(set.steps[i].previous)] + 1;
  }
  const bool all_made = std::all_of(set.clips.begin(), set.clips.end(), [](const PreparedClip& clip) { return clip.made; });
  const auto teaches = [&](int clip) { return all_made || !set.clips[clip].made; };
  std::map<int, std::map<int, int>> walks;  // per style: number of each clip that manners are learned from
  for (size_t c = 0; c < set.classes.size(); ++c) {
    for (const int step : set.classes[c].members) {
      if (teaches(set.steps[step].clip)) walks[(*fitted)[c].primitive.style_index].emplace(set.steps[step].clip, 0);
    }
  }
  for (auto& [style, numbers] : walks) {
    int count = 0;
    for (auto& [clip, number] : numbers) number = count++;
  }
  for (size_t c = 0; c < set.classes.size(); ++c) {
    const StepClass& members = set.classes[c];
    FittedPrimitive& primitive = (*fitted)[c];
    const GaussianMixture& mixture = primitive.primitive.mixture;
    Eigen::MatrixXd whitened(primitive.latents.rows(), primitive.latents.cols());
    std::vector<int> components;
    for (Eigen::Index m = 0; m < whitened.cols(); ++m) {
      const Eigen::VectorXd latent = primitive.latents.col(m);
      components.push_back(mixture.MostLikely(latent));
      whitened.col(m) = Whiten(mixture.Component(components.back()), latent);
    }
    const std::map<int, std::vector<int>> places = SteadyByClip(set, members);
    MannerSteps steps;
    std::map<int, int>& numbers = walks[primitive.primitive.style_index];
    steps.walks = static_cast<int>(numbers.size());
    steps.component_weights.resize(mixture.size());
    for (int k = 0; k < mixture.size(); ++k) steps.component_weights[k] = std::exp(mixture.Component(k).log_weight);
    std::vector<int> used;
    for (const auto& [clip, of_clip] : places) {
      if (!teaches(clip)) continue;
      for (const int m : of_clip) {
        const int step = members.members[m];
        used.push_back(m);
        steps.component.push_back(components[m]);
        steps.walk.push_back(numbers.at(clip));
        steps.ordinal.push_back(ordinals[step]);
        steps.seconds.push_back(set.steps[step].span.frames() / set.clips[clip].clip.frame_rate_hz());
      }
    }
    steps.whitened = whitened(Eigen::all, used);
    const MannerModel& manner = primitive.primitive.manner = FitManner(steps);
    if (manner.empty()) continue;
    // Copies have a manner too, as their steps follow each other like those of any walk.
    primitive.manners = Eigen::MatrixXd::Zero(whitened.rows(), whitened.cols());
    for (size_t m = 0; m < members.members.size(); ++m) {
      const auto of_clip = places.find(set.steps[members.members[m]].clip);
      if (of_clip == places.end()) continue;
      primitive.manners.col(static_cast<Eigen::Index>(m)) = PredictManner(manner.share, whitened(Eigen::all, of_clip->second));
    }
  }
  CentreManners(fitted);
}

}  // namespace morphograph
