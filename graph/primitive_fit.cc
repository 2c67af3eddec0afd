#include "graph/primitive_fit.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "datasets/errors.h"
#include "datasets/forward_kinematics.h"
#include "primitives/frame_distance.h"
#include "primitives/gaussian_mixture.h"
#include "primitives/rotation_math.h"
#include "primitives/time_warp.h"
#include "primitives/weighted_pca.h"
#include "primitives/whitening.h"

namespace morphograph {
namespace {

// Instants of a step that are compared when it is aligned: sub-frame at 30 frames a second.
constexpr int kAlignmentFrames = 25;
// Draws the fitted warp towards uniform time, so that the stairs of a whole-frame path stay out.
constexpr double kWarpRegularisation = 1e-3;
// Candidates for the reference segment, spread evenly over the class.
constexpr int kReferenceCandidates = 40;

constexpr int kExamplesPerComponent = 8;

using PoseClouds = std::vector<Eigen::Matrix3Xd>;

// Joint positions at kAlignmentFrames instants of a step, uniform in time.
PoseClouds AlignmentPoses(const StepSampler& sampler, const PoseLayout& layout, const MeanRotations& means) {
  Eigen::VectorXd frames(kAlignmentFrames);
  for (int i = 0; i < kAlignmentFrames; ++i) {
    frames[i] = sampler.span().FrameAt(static_cast<double>(i) / (kAlignmentFrames - 1));
  }
  const Eigen::MatrixXd poses = sampler.PosesAt(frames);
  std::vector<Eigen::Quaterniond> rotations(means);
  PoseClouds clouds;
  WorldPose pose;
  for (int i = 0; i < kAlignmentFrames; ++i) {
    for (size_t n = 0; n < layout.active_joints().size(); ++n) {
      const int joint = layout.active_joints()[n];
      rotations[joint] = ExpMapAbout(means[joint], poses.block<3, 1>(3 + 3 * static_cast<Eigen::Index>(n), i));
    }
    ForwardKinematics(layout.skeleton(), rotations.data(), poses.block<3, 1>(0, i), &pose);
    clouds.push_back(pose.positions);
  }
  return clouds;
}

// Index of the segment with the least mean distance to the others, time taken as uniform. First of equals.
int PickReference(const std::vector<PoseClouds>& clouds, const std::vector<int>& eligible, const Eigen::VectorXd& weights) {
  const int count = std::min(kReferenceCandidates, static_cast<int>(eligible.size()));
  std::vector<int> candidates;
  for (int i = 0; i < count; ++i) candidates.push_back(eligible[static_cast<size_t>(i) * eligible.size() / count]);
  Eigen::MatrixXd distances = Eigen::MatrixXd::Zero(count, count);
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      for (int i = 0; i < kAlignmentFrames; i += 4) {
        distances(a, b) += FrameDistance(clouds[candidates[a]][i], clouds[candidates[b]][i], weights);
      }
      distances(b, a) = distances(a, b);
    }
  }
  return candidates[ChooseReference(distances)];
}

TimeWarp Align(const PoseClouds& reference, const PoseClouds& test, const Eigen::VectorXd& weights) {
  const Eigen::MatrixXd cost = FrameDistanceMatrix(reference, test, weights);
  return TimeWarp::Fit(DynamicTimeWarp(cost), kAlignmentFrames, kAlignmentFrames, kWarpKnots, kWarpRegularisation);
}

// Contact labels of a step, read off on its canonical timeline.
ContactChances ContactsOf(const PreparedClip& clip, const StepSpan& span, const TimeWarp& warp) {
  ContactChances contacts;
  for (int i = 0; i < kPhaseSamples; ++i) {
    const int frame = std::clamp(static_cast<int>(std::lround(span.FrameAt(warp(PhaseOfSample(i))))), 0,
                                 clip.clip.frame_count() - 1);
    contacts.col(i) = clip.contacts.planted.col(frame).cast<double>();
  }
  return contacts;
}

}  // namespace

FittedPrimitive FitPrimitive(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps, const StepClass& members,
                             const PoseLayout& layout, const MeanRotations& means, const Eigen::VectorXd& channel_weights,
                             const PrimitiveFitOptions& options) {
  const int count = static_cast<int>(members.members.size());
  const Eigen::VectorXd distance_weights = FrameDistanceWeights(layout.skeleton());
  std::vector<StepSampler> samplers;
  std::vector<PoseClouds> clouds;
  std::vector<int> steady;
  for (int i = 0; i < count; ++i) {
    const TrainingStep& step = steps[members.members[i]];
    samplers.emplace_back(clips[step.clip].clip, layout, means, step.span);
    clouds.push_back(AlignmentPoses(samplers.back(), layout, means));
    if (step.steady) steady.push_back(i);
  }
  const PoseClouds& reference = clouds[PickReference(clouds, steady, distance_weights)];

  const Eigen::VectorXd weights = StepWeights(channel_weights);
  Eigen::MatrixXd vectors(weights.size(), count);
  FittedPrimitive fitted;
  MotionPrimitive& primitive = fitted.primitive;
  for (int i = 0; i < count; ++i) {
    const TrainingStep& step = steps[members.members[i]];
    const TimeWarp warp = Align(reference, clouds[i], distance_weights);
    vectors.col(i) = samplers[i].Vector(warp);
    if (!step.steady) continue;
    primitive.contacts += ContactsOf(clips[step.clip], step.span, warp) / static_cast<double>(steady.size());
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
  GaussianMixtureOptions mixture_options;
  // On a handful of points the information criterion takes every point for a component of its own.
  mixture_options.max_components =
      std::clamp(static_cast<int>(steady.size()) / kExamplesPerComponent, 1, options.largest_mixture);
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
