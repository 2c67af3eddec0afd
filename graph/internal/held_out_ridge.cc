#include "graph/internal/held_out_ridge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>
#include <map>

#include "primitives/matrix_factors.h"

namespace morphograph::internal {
namespace {

constexpr double kRidges[] = {0.01, 0.03, 0.1, 0.3, 1, 3, 10};  // of the inputs' energy
constexpr double kGain = 0.02;  // part of the error on groups left out that a map has to take away
constexpr double kLeastRidge = 1e-12;

}  // namespace

HeldOutRidge::HeldOutRidge(int outputs, double energy)
    : energy_(energy), missed_(Eigen::MatrixXd::Zero(outputs, std::size(kRidges))), whole_(Eigen::VectorXd::Zero(outputs)) {}

void HeldOutRidge::Add(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs, const std::vector<int>& groups) {
  std::map<int, std::vector<Eigen::Index>> members;
  for (size_t i = 0; i < groups.size(); ++i) members[groups[i]].push_back(static_cast<Eigen::Index>(i));
  const SymmetricFactors factors = FactorSymmetric(inputs * inputs.transpose());
  const Eigen::MatrixXd turned = factors.vectors.transpose() * inputs;
  const Eigen::MatrixXd shared = outputs * turned.transpose();
  whole_ += outputs.rowwise().squaredNorm();
  auto& maps = maps_.emplace_back();
  for (Eigen::Index r = 0; r < missed_.cols(); ++r) {
    const double ridge = std::max(kLeastRidge, kRidges[r] * energy_ * static_cast<double>(groups.size()));
    const Eigen::VectorXd gains = (factors.values.array().max(0) + ridge).inverse();
    const Eigen::MatrixXd map = shared * gains.asDiagonal();
    maps.push_back(map * factors.vectors.transpose());
    // What a group's examples would miss, had the map not seen them: the residuals, freed of what the group itself told (as in FitLinearMap).
    const Eigen::MatrixXd residuals = outputs - map * turned;
    for (const auto& [group, of_group] : members) {
      const Eigen::MatrixXd part = turned(Eigen::all, of_group);
      Eigen::MatrixXd blind = -part.transpose() * gains.asDiagonal() * part;
      blind.diagonal().array() += 1;
      const Eigen::MatrixXd unseen = blind.llt().solve(residuals(Eigen::all, of_group).transpose());
      missed_.col(r) += unseen.colwise().squaredNorm().transpose();
    }
  }
}

std::vector<Eigen::MatrixXd> HeldOutRidge::Maps() const {
  std::vector<Eigen::MatrixXd> best;
  for (const auto& maps : maps_) best.push_back(Eigen::MatrixXd::Zero(maps.front().rows(), maps.front().cols()));
  for (Eigen::Index output = 0; output < whole_.size(); ++output) {
    Eigen::Index least = 0;
    if (!(missed_.row(output).minCoeff(&least) < (1 - kGain) * whole_[output])) continue;
    for (size_t i = 0; i < maps_.size(); ++i) best[i].row(output) = maps_[i][static_cast<size_t>(least)].row(output);
  }
  return best;
}

}  // namespace morphograph::internal
