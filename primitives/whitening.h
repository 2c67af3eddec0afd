#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "primitives/gaussian_mixture.h"

namespace morphograph {

/// w = L^-1 (x - mean): standard normal where x follows the component N(mean, L L^T).
inline Eigen::VectorXd Whiten(const MixtureComponent& component, const Eigen::VectorXd& latent) {
  return component.cholesky.triangularView<Eigen::Lower>().solve(latent - component.mean);
}

/// Inverse of Whiten.
inline Eigen::VectorXd Colour(const MixtureComponent& component, const Eigen::VectorXd& whitened) {
  return component.mean + component.cholesky.triangularView<Eigen::Lower>() * whitened;
}

/// ln |L|: what a density of whitened values loses when it is taken over the latents.
inline double LogVolume(const MixtureComponent& component) { return component.cholesky.diagonal().array().log().sum(); }

}  // namespace morphograph
