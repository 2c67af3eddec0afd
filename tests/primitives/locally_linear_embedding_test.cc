#include "primitives/locally_linear_embedding.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <boost/random/uniform_real_distribution.hpp>
#include <random>

#include "primitives/weighted_pca.h"

namespace morphograph {
namespace {

// A plane of 2.2 x 1, rolled up in space: (3 x N) points and their (2 x N) places on the plane.
struct RolledPlane {
  Eigen::MatrixXd points, places;
};

RolledPlane Roll(int count, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  boost::random::uniform_real_distribution<double> uniform(0, 1);
  RolledPlane plane{Eigen::MatrixXd(3, count), Eigen::MatrixXd(2, count)};
  for (int i = 0; i < count; ++i) {
    const double along = 2.2 * uniform(rng), across = uniform(rng), radius = 0.5;
    plane.places.col(i) << along, across;
    plane.points.col(i) << radius * std::sin(along / radius), across, radius * std::cos(along / radius);
  }
  return plane;
}

// Share of the places' variance that no affine map of the coordinates gives.
double AffineResidual(const Eigen::MatrixXd& coordinates, const Eigen::MatrixXd& places) {
  Eigen::MatrixXd terms(coordinates.cols(), coordinates.rows() + 1);
  terms << coordinates.transpose(), Eigen::VectorXd::Ones(coordinates.cols());
  const Eigen::MatrixXd wanted = places.transpose();
  const Eigen::MatrixXd residual = wanted - terms * (terms.transpose() * terms).llt().solve(terms.transpose() * wanted);
  const Eigen::MatrixXd centred = wanted.rowwise() - wanted.colwise().mean();
  return residual.squaredNorm() / centred.squaredNorm();
}

TEST(LocallyLinearEmbedding, UnrollsAPlaneUpToAnAffineMap) {
  const RolledPlane plane = Roll(500, 1);
  const LocallyLinearEmbedding embedding = FitLocallyLinearEmbedding(plane.points, {.neighbours = 10, .components = 2});
  EXPECT_EQ(embedding.pieces, 1);
  const double unrolled = AffineResidual(embedding.coordinates, plane.places);
  EXPECT_LT(unrolled, 0.05);
  const WeightedPca pca = FitWeightedPca(plane.points, Eigen::Vector3d::Ones(), {.variance_kept = 1, .max_components = 2});
  EXPECT_GT(AffineResidual(pca.ProjectAll(plane.points), plane.places), 5 * unrolled);  // no plane cuts it flat
}

TEST(LocallyLinearEmbedding, CoordinatesAreCentredScaledAndUncorrelated) {
  const LocallyLinearEmbedding embedding = FitLocallyLinearEmbedding(Roll(200, 2).points, {.neighbours = 8, .components = 3});
  const Eigen::MatrixXd& y = embedding.coordinates;
  EXPECT_LT(y.rowwise().mean().cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((y * y.transpose() / 200 - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_TRUE(std::is_sorted(embedding.eigenvalues.begin(), embedding.eigenvalues.end()));
}

TEST(LocallyLinearEmbedding, WeightsSumToOneAndMakeThePoint) {
  Eigen::MatrixXd corners(2, 3);
  corners << 0, 1, 0, 0, 0, 1;
  const Eigen::Vector2d point(0.2, 0.3);
  const Eigen::VectorXd weights = ReconstructionWeights(point, corners, 1e-9);
  EXPECT_NEAR(weights.sum(), 1, 1e-12);
  EXPECT_LT((corners * weights - point).norm(), 1e-6);
  // More regularisation draws the weights together.
  const Eigen::VectorXd even = ReconstructionWeights(point, corners, 1e6);
  EXPECT_LT((even.array() - 1.0 / 3).abs().maxCoeff(), 1e-4);
  const Eigen::MatrixXd on_the_point = point.replicate(1, 4);
  EXPECT_LT((ReconstructionWeights(point, on_the_point, 1e-3).array() - 0.25).abs().maxCoeff(), 1e-12);
}

TEST(LocallyLinearEmbedding, EmbedsAndReconstructsWhatItHasNotSeen) {
  const RolledPlane seen = Roll(500, 1), unseen = Roll(60, 9);
  const LocallyLinearEmbedding embedding = FitLocallyLinearEmbedding(seen.points, {.neighbours = 10, .components = 2});
  const WeightedPca pca = FitWeightedPca(seen.points, Eigen::Vector3d::Ones(), {.variance_kept = 1, .max_components = 2});
  double by_neighbours = 0, by_plane = 0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::VectorXd point = unseen.points.col(i);
    by_neighbours += (embedding.Reconstruct(embedding.Embed(point)) - point).squaredNorm();
    by_plane += (pca.Reconstruct(pca.Project(point)) - point).squaredNorm();
  }
  EXPECT_LT(by_neighbours, 0.2 * by_plane);
  // A training sample is its own nearest neighbour.
  EXPECT_LT((embedding.Embed(seen.points.col(7)) - embedding.coordinates.col(7)).norm(), 1e-3);
}

TEST(LocallyLinearEmbedding, CountsThePieces) {
  Eigen::MatrixXd two(3, 80);
  two.leftCols(40) = Roll(40, 3).points;
  two.rightCols(40) = Roll(40, 4).points.colwise() + Eigen::Vector3d(100, 0, 0);
  EXPECT_EQ(FitLocallyLinearEmbedding(two, {.neighbours = 6, .components = 2}).pieces, 2);
}

TEST(LocallyLinearEmbedding, TakesAsFewSamplesAsItSays) {
  const Eigen::MatrixXd few = Roll(4, 5).points;
  const LocallyLinearEmbedding embedding = FitLocallyLinearEmbedding(few, {.neighbours = 12, .components = 2});
  EXPECT_TRUE(embedding.coordinates.allFinite());
  EXPECT_THROW(FitLocallyLinearEmbedding(few, {.neighbours = 12, .components = 3}), std::invalid_argument);
}

TEST(LocallyLinearEmbedding, NamesWhatIsWrong) {
  const Eigen::MatrixXd points = Roll(30, 6).points;
  EXPECT_THROW(FitLocallyLinearEmbedding(points, {.neighbours = 1}), std::invalid_argument);
  EXPECT_THROW(FitLocallyLinearEmbedding(points, {.regularisation = 0}), std::invalid_argument);
  EXPECT_THROW(FitLocallyLinearEmbedding(points, {.components = 0}), std::invalid_argument);
  EXPECT_THROW(FitLocallyLinearEmbedding(points).Embed(Eigen::Vector2d::Zero()), std::invalid_argument);
  Eigen::MatrixXd broken = points;
  broken(1, 3) = std::nan("");
  EXPECT_THROW(FitLocallyLinearEmbedding(broken), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
