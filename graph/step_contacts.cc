#include "graph/step_contacts.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "graph/internal/held_out_ridge.h"

namespace morphograph {
namespace {

using Indices = std::vector<Eigen::Index>;

// The given rows of the steps' contacts at one sample, without their means: (rows x steps taken).
Eigen::MatrixXd Deviations(const std::vector<ContactProfile>& steps, const Indices& taken, const std::vector<int>& rows, int sample) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(taken.size()));
  for (Eigen::Index i = 0; i < values.cols(); ++i) values.col(i) = steps[static_cast<size_t>(taken[i])](rows, sample);
  return values.colwise() - values.rowwise().mean();
}

Indices PlantedSteps(const std::vector<ContactProfile>& steps, int part, int sample) {
  Indices planted;
  for (size_t i = 0; i < steps.size(); ++i) {
    if (steps[i](kPlantedChance + part, sample) > 0) planted.push_back(static_cast<Eigen::Index>(i));
  }
  return planted;
}

std::vector<int> MotionRows(int part) { return {kPlantedHeight + part, kSlideLeft + part, kSlideForward + part}; }

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

StepContacts FitStepContacts(const std::vector<ContactProfile>& steps, const Eigen::MatrixXd& latents, const std::vector<int>& clips) {
  const Eigen::Index count = latents.cols();
  if (static_cast<Eigen::Index>(steps.size()) != count || clips.size() != steps.size() || count == 0) {
    throw std::invalid_argument("FitStepContacts: needs contacts, latent and clip of every step, and at least one");
  }
  StepContacts told;
  told.at_zero = MeanContacts(steps);
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(kContactRows * kPhaseSamples, latents.rows());
  Indices all;
  for (Eigen::Index i = 0; i < count; ++i) all.push_back(i);
  const double energy = latents.size() > 0 ? latents.array().square().mean() : 0;
  const Eigen::VectorXd mean = latents.rowwise().mean();
  const Eigen::MatrixXd centred = latents.colwise() - mean;
  for (int part = 0; part < kFootParts; ++part) {
    const std::vector<int> rows = MotionRows(part);
    internal::HeldOutRidge chances(1, energy), motions(static_cast<int>(rows.size()), energy);
    std::vector<int> samples;  // at which the part is ever planted
    std::vector<Eigen::VectorXd> centres;
    for (int sample = 0; sample < kPhaseSamples; ++sample) {
      chances.Add(centred, Deviations(steps, all, {kPlantedChance + part}, sample), clips);
      const Indices planted = PlantedSteps(steps, part, sample);
      if (planted.empty()) continue;
      const Eigen::MatrixXd places = latents(Eigen::all, planted);
      std::vector<int> of_clips;
      for (const Eigen::Index i : planted) of_clips.push_back(clips[static_cast<size_t>(i)]);
      samples.push_back(sample);
      centres.push_back(places.rowwise().mean());
      motions.Add(places.colwise() - centres.back(), Deviations(steps, planted, rows, sample), of_clips);
    }
    const std::vector<Eigen::MatrixXd> of_chances = chances.Maps(), of_motions = motions.Maps();
    for (int sample = 0; sample < kPhaseSamples; ++sample) {
      const Eigen::RowVectorXd of_chance = of_chances[static_cast<size_t>(sample)];
      map.row(kContactRows * sample + kPlantedChance + part) = of_chance;
      told.at_zero(kPlantedChance + part, sample) -= of_chance * mean;
    }
    for (size_t k = 0; k < samples.size(); ++k) {
      for (size_t r = 0; r < rows.size(); ++r) map.row(kContactRows * samples[k] + rows[r]) = of_motions[k].row(static_cast<Eigen::Index>(r));
      // Those that are planted have a mean latent of their own.
      told.at_zero(rows, samples[k]) -= of_motions[k] * centres[k];
    }
  }
  told.map = map.cast<float>();
  return told;
}

}  // namespace morphograph
