#include "graph/step_contacts.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "primitives/matrix_factors.h"

namespace morphograph {
namespace {

constexpr int kMotionRows = kContactRows - kFootParts;  // heights and velocities
constexpr double kRidges[] = {0.01, 0.03, 0.1, 0.3, 1, 3, 10};  // of the latents' mean energy
constexpr double kGain = 0.02;  // part of the error on clips left out that a map has to take away

}  // namespace

ContactProfile MeasureStepContacts(const PreparedClip& clip, const PoseLayout& layout, const StepSpan& span, const TimeWarp& warp) {
  const int last = clip.clip.frame_count() - 1;
  ContactProfile contacts(kContactRows, kPhaseSamples);
  for (int i = 0; i < kPhaseSamples; ++i) {
    const double at = std::clamp(span.FrameAt(warp(PhaseOfSample(i))), 0.0, static_cast<double>(last));
    const int nearest = static_cast<int>(std::lround(at));
    const int low = std::clamp(static_cast<int>(std::floor(at)), 0, std::max(0, last - 1)), high = std::min(low + 1, last);
    const double t = at - low;
    const Eigen::Quaterniond heading_from_world = Yaw(-layout.HeadingOf(clip.clip.rotation(nearest, layout.active_joints()[0])));
    for (int part = 0; part < kFootParts; ++part) {
      const Eigen::Matrix3Xd& points = (part % 2 == 0 ? clip.contacts.heels : clip.contacts.balls)[part / 2];
      const Eigen::Vector3d slide = heading_from_world * (points.col(high) - points.col(low)) * clip.clip.frame_rate_hz();
      contacts(kPlantedChance + part, i) = clip.contacts.planted(part, nearest) != 0 ? 1 : 0;
      contacts(kPlantedHeight + part, i) = (1 - t) * points(1, low) + t * points(1, high);
      contacts(kSlideLeft + part, i) = slide.x();
      contacts(kSlideForward + part, i) = slide.z();
    }
  }
  return contacts;
}

ContactProfile MeanContacts(const std::vector<ContactProfile>& steps) {
  if (steps.empty()) throw std::invalid_argument("MeanContacts: no steps");
  ContactProfile mean(kContactRows, kPhaseSamples);
  for (int i = 0; i < kPhaseSamples; ++i) {
    for (int part = 0; part < kFootParts; ++part) {
      double planted = 0;
      Eigen::Vector3d of_planted = Eigen::Vector3d::Zero(), of_all = of_planted;
      for (const ContactProfile& step : steps) {
        const Eigen::Vector3d values(step(kPlantedHeight + part, i), step(kSlideLeft + part, i), step(kSlideForward + part, i));
        planted += step(kPlantedChance + part, i);
        of_planted += step(kPlantedChance + part, i) * values;
        of_all += values;
      }
      const double count = static_cast<double>(steps.size());
      const Eigen::Vector3d values = planted > 0 ? Eigen::Vector3d(of_planted / planted) : Eigen::Vector3d(of_all / count);
      mean(kPlantedChance + part, i) = planted / count;
      for (int row = 0; row < 3; ++row) mean(kFootParts * (row + 1) + part, i) = values[row];
    }
  }
  return mean;
}

Eigen::MatrixXf FitContactMap(const std::vector<ContactProfile>& steps, const ContactProfile& mean, const Eigen::MatrixXd& latents,
                              const std::vector<int>& clips) {
  const Eigen::Index count = latents.cols();
  if (static_cast<Eigen::Index>(steps.size()) != count || clips.size() != steps.size() || count == 0) {
    throw std::invalid_argument("FitContactMap: needs contacts, latent and clip of every step, and at least one");
  }
  Eigen::MatrixXd deviations(kMotionRows * kPhaseSamples, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ContactProfile& step = steps[static_cast<size_t>(i)];
    Eigen::MatrixXd deviation = step.bottomRows(kMotionRows) - mean.bottomRows(kMotionRows);
    for (int row = 0; row < kMotionRows; ++row) deviation.row(row).array() *= step.row(row % kFootParts).array();
    deviations.col(i) = deviation.reshaped();
  }
  const auto energies = [](const Eigen::MatrixXd& values) {  // by row of the profile
    Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(kMotionRows);
    for (Eigen::Index e = 0; e < values.rows(); ++e) sums[e % kMotionRows] += values.row(e).squaredNorm();
    return sums;
  };
  std::map<int, std::vector<Eigen::Index>> members;
  for (Eigen::Index i = 0; i < count; ++i) members[clips[static_cast<size_t>(i)]].push_back(i);

  const SymmetricFactors factors = FactorSymmetric(latents * latents.transpose());
  const Eigen::MatrixXd turned = factors.vectors.transpose() * latents;
  const Eigen::MatrixXd shared = deviations * turned.transpose();
  const double energy = factors.values.cwiseMax(0).mean();
  Eigen::MatrixXd best = Eigen::MatrixXd::Zero(deviations.rows(), latents.rows());
  Eigen::ArrayXd least = (1 - kGain) * energies(deviations);
  for (const double ridge : kRidges) {
    const Eigen::VectorXd gains = (factors.values.array().max(0) + std::max(ridge * energy, 1e-12)).inverse();
    const Eigen::MatrixXd map = shared * gains.asDiagonal();
    // What a clip's steps would miss, had the map not seen them: the residuals, freed of what the clip itself told (as in FitLinearMap).
    Eigen::MatrixXd unseen = deviations - map * turned;
    for (const auto& [clip, of_clip] : members) {
      const Eigen::MatrixXd part = turned(Eigen::all, of_clip);
      Eigen::MatrixXd blind = -part.transpose() * gains.asDiagonal() * part;
      blind.diagonal().array() += 1;
      const Eigen::MatrixXd seen = unseen(Eigen::all, of_clip);
      unseen(Eigen::all, of_clip) = blind.llt().solve(seen.transpose()).transpose();
    }
    const Eigen::ArrayXd missed = energies(unseen);
    for (Eigen::Index e = 0; e < map.rows(); ++e) {
      if (missed[e % kMotionRows] < least[e % kMotionRows]) best.row(e) = map.row(e);
    }
    least = least.min(missed);
  }
  return (best * factors.vectors.transpose()).cast<float>();
}

}  // namespace morphograph
