#pragma once

#include <Eigen/Core>
#include <vector>

namespace morphograph::internal {

/// Linear regression from inputs to outputs whose ridges the data choose: a Gaussian process with the kernel c_e sum_d s_d^2p x_d y_d for
/// output e, of maximum marginal likelihood. Each output has its own c_e and noise, as some follow from the inputs and some do not; the
/// power p, 0 to 1, says how much less inputs of small scale s_d are believed.
struct LinearRidges {
  Eigen::VectorXd scale;           // s_d^p (D)
  Eigen::VectorXd ridge;           // (E) noise over c_e
  Eigen::VectorXd noise_variance;  // (E)
  double log_likelihood = 0;       // of the pairs it was chosen by
};

/// @param inputs  (D x N). @param outputs  (E x N). @param scales  s (D), > 0; empty: all inputs are believed alike.
LinearRidges SearchLinearRidges(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                                const Eigen::VectorXd& scales = {});

/// The map (E x D) that pairs give under these ridges, and what it misses each pair by when the pairs of the same group are left out
/// (Rasmussen & Williams 2006, Eq. 5.12, for blocks).
struct LinearMap {
  Eigen::MatrixXd map;       // (E x D)
  Eigen::MatrixXd residuals; // (E x N)
};

/// @param groups  per pair; empty: every pair is on its own.
LinearMap FitLinearMap(const LinearRidges& ridges, const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                    const std::vector<int>& groups);

}  // namespace morphograph::internal
