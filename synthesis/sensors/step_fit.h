#pragma once

#include <Eigen/Core>

#include "synthesis/sensors/captured_steps.h"
#include "synthesis/sensors/step_search.h"

namespace morphograph {

struct StepFitOptions {
  int neighbours = 1000;      // captured steps that make the local model
  double sigma_m_s2 = 1.5;    // of a reading about what the model says: noise, mounting, and what the model does not hold
};

/// A step as its readings make it likely.
struct FittedStep {
  Eigen::MatrixXd poses;     // (channels x kPhaseSamples), about CapturedSteps::means()
  double residual_m_s2 = 0;  // root mean square of readings less the model's
  Eigen::VectorXd styles;    // shares of the nearest captured steps
};

/// Maximum a posteriori step given its readings (METHODS section 5): poses and readings of the captured steps of that side whose readings are nearest are taken as
/// jointly normal, which makes both linear in as many latents as there are neighbours, and readings deviate from the step's by `sigma`.
///   latents = argmin |latents|^2 + |readings - mean - R latents|^2 / sigma^2,  poses = mean + P latents
/// with R and P the neighbours' deviations from their mean over sqrt(neighbours). Samples outside of the stream say nothing.
/// @param readings  (3 * sensors x frames) of the whole stream.
FittedStep FitStep(const CapturedSteps& steps, const Eigen::MatrixXd& readings, const FoundStep& found, const StepFitOptions& options = {});

}  // namespace morphograph
