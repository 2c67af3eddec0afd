#include "graph/primitive_fit.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "datasets/errors.h"
#include "graph/step_alignment.h"
#include "graph/step_contacts.h"
#include "primitives/gaussian_mixture.h"
#include "primitives/weighted_pca.h"
#include "primitives/whitening.h"

namespace morphograph {
namespace {

constexpr int kFewestPerComponent = 8;  // steps
// One component at least for every so many captured steps, whatever the information criterion says: in the diagonal form it counts two
// parameters a latent and component, and on bnr one or two components lump straight and turning steps together. Four are better on clips left out, too.
constexpr int kCapturedPerComponent = 35;

// What lies outside of the step follows from what lies inside.
void LightenMargins(int channels, Eigen::VectorXd* weights) {
  constexpr double kNextToNothing = 1e-3;
  for (int i = 0; i < kPhaseSamples; ++i) {
    const double phase = PhaseOfSample(i);
    if (phase < 0 || phase > 1) weights->segment(i * channels, channels) *= kNextToNothing;
  }
}

}  // namespace

FittedPrimitive FitPrimitive(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps, const StepClass& members,
                             const PoseLayout& layout, const MeanRotations& means, const Eigen::VectorXd& channel_weights,
                             const PrimitiveFitOptions& options) {
  const int count = static_cast<int>(members.members.size());
  AlignedClass aligned = AlignClass(clips, steps, members, layout, means);
  const std::vector<int>& steady = aligned.steady;
  Eigen::MatrixXd& vectors = aligned.vectors;
  if (!options.variant.timing) {
    const Eigen::VectorXd mean = vectors(Eigen::all, steady).bottomRows(kTimingValues).rowwise().mean();
    vectors.bottomRows(kTimingValues).colwise() = mean;
  }
  FittedPrimitive fitted;
  MotionPrimitive& primitive = fitted.primitive;
  std::vector<ContactProfile> contacts;
  std::vector<int> sources;
  for (const int i : steady) {
    const TrainingStep& step = steps[members.members[i]];
    contacts.push_back(MeasureStepContacts(clips[step.clip], layout, step.span, aligned.warps[i]));
    sources.push_back(clips[step.clip].source);
    ++primitive.examples;
    if (clips[step.clip].made) ++primitive.made_examples;
  }
  const TrainingStep& model_step = steps[members.members[steady.front()]];
  primitive.name = members.primitive;
  primitive.style = members.style;
  primitive.start = model_step.start;
  primitive.end = model_step.end;
  // A stand and a double stance bound the same class; one that holds real stands is called after them.
  for (const int i : steady) {
    const TrainingStep& step = steps[members.members[i]];
    if (step.start == KeyframeLabel::kStanding) primitive.start = step.start;
    if (step.end == KeyframeLabel::kStanding) primitive.end = step.end;
  }
  primitive.initial_weight = primitive.examples;

  const Eigen::MatrixXd steady_vectors = vectors(Eigen::all, steady);
  Eigen::VectorXd weights = StepWeights(channel_weights);
  if (!options.variant.margins) LightenMargins(layout.channels(), &weights);
  const WeightedPca pca = FitWeightedPca(steady_vectors, weights.cwiseAbs2(), {.variance_kept = options.variance_kept});
  if (pca.components() == 0) {
    throw DatasetError(members.primitive, "its " + std::to_string(steady.size()) +
                                              " steps are all alike; a model needs steps that differ");
  }
  primitive.reduction.mean = pca.mean;
  primitive.reduction.basis = pca.basis.cast<float>();
  primitive.reduction.variance_kept = pca.variance_kept;
  fitted.latents.resize(pca.basis.cols(), count);
  for (int i = 0; i < count; ++i) fitted.latents.col(i) = pca.Project(vectors.col(i));

  const Eigen::MatrixXd steady_latents = fitted.latents(Eigen::all, steady);
  StepContacts told = FitStepContacts(contacts, steady_latents, sources);
  primitive.contacts = std::move(told.at_zero);
  primitive.contact_map = std::move(told.map);
  GaussianMixtureOptions mixture_options;
  // On a handful of points the information criterion takes every point for a component of its own.
  mixture_options.max_components =
      std::clamp(static_cast<int>(steady.size()) / kFewestPerComponent, 1, options.largest_mixture);
  mixture_options.min_components = std::clamp((primitive.examples - primitive.made_examples) / kCapturedPerComponent, 1, mixture_options.max_components);
  std::mt19937_64 rng(options.seed);
  const GaussianMixtureSelection selection = SelectGaussianMixture(steady_latents, mixture_options, rng);
  primitive.mixture = selection.best.mixture;
  primitive.covariance_form = selection.best.form;
  for (Eigen::Index i = 0; i < steady_latents.cols(); ++i) {
    const int c = primitive.mixture.MostLikely(steady_latents.col(i));
    primitive.latent_radius =
        std::max(primitive.latent_radius, Whiten(primitive.mixture.Component(c), steady_latents.col(i)).norm());
  }
  return fitted;
}

}  // namespace morphograph
