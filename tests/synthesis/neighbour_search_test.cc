#include "synthesis/sensors/neighbour_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

// Sixteenths, so that distances are exact in whatever order they are summed.
Eigen::MatrixXf RandomSixteenths(Eigen::Index dims, Eigen::Index count, std::mt19937_64& rng) {
  return (16 * testing::RandomNormal(dims, count, rng).cast<float>()).array().round() / 16;
}

// By all distances, sorted; of equals the lower index first.
std::vector<Neighbour> ByBruteForce(const Eigen::MatrixXf& points, const Eigen::VectorXf& query, int count) {
  std::vector<Neighbour> all;
  for (Eigen::Index i = 0; i < points.cols(); ++i) all.push_back({(points.col(i) - query).squaredNorm(), static_cast<int>(i)});
  std::sort(all.begin(), all.end());
  all.resize(static_cast<std::size_t>(std::min<Eigen::Index>(count, points.cols())));
  return all;
}

void ExpectSame(std::vector<Neighbour> found, const std::vector<Neighbour>& wanted) {
  std::sort(found.begin(), found.end());
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].index, wanted[i].index) << i;
    EXPECT_EQ(found[i].squared_distance, wanted[i].squared_distance);
  }
}

TEST(NeighbourSearch, FindsWhatBruteForceFinds) {
  std::mt19937_64 rng(3);
  std::vector<Neighbour> found;
  for (const int dims : {1, 3, 12, 18}) {
    // Clusters of unlike size, as readings have them.
    Eigen::MatrixXf points = RandomSixteenths(dims, 3000, rng);
    points.leftCols(1000) /= 16;
    const NeighbourSearch search(points);
    for (const int count : {1, 7, 500, 2999, 5000}) {
      const Eigen::VectorXf query = RandomSixteenths(dims, 1, rng);
      search.Nearest(query, count, &found);
      ExpectSame(found, ByBruteForce(points, query, count));
    }
  }
}

TEST(NeighbourSearch, OfEqualPointsTheFirstAreFound) {
  // Whole numbers, so that equal distances are equal to the last bit.
  std::mt19937_64 rng(5);
  const Eigen::MatrixXf points = testing::RandomNormal(3, 2000, rng).cast<float>().array().round();
  const NeighbourSearch search(points);
  std::vector<Neighbour> found;
  for (const int count : {1, 10, 333}) {
    search.Nearest(Eigen::Vector3f::Zero(), count, &found);
    ExpectSame(found, ByBruteForce(points, Eigen::Vector3f::Zero(), count));
  }
}

TEST(NeighbourSearch, ABoundThatHoldsChangesNothing) {
  std::mt19937_64 rng(7);
  const Eigen::MatrixXf points = RandomSixteenths(12, 4000, rng);
  const NeighbourSearch search(points);
  const Eigen::VectorXf query = RandomSixteenths(12, 1, rng);
  const std::vector<Neighbour> wanted = ByBruteForce(points, query, 100);
  std::vector<Neighbour> found;
  search.Nearest(query, 100, &found, wanted.back().squared_distance * 1.0001F);
  ExpectSame(found, wanted);
  search.Nearest(query, 100, &found, wanted[40].squared_distance * 1.0001F);
  EXPECT_GE(found.size(), 41U);
  EXPECT_LT(found.size(), 100U) << "a bound that is too low finds what is within it";
}

TEST(NeighbourSearch, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(NeighbourSearch(Eigen::MatrixXf(12, 0)), std::invalid_argument);
  Eigen::MatrixXf points = Eigen::MatrixXf::Ones(2, 3);
  const NeighbourSearch search(points);
  std::vector<Neighbour> found;
  EXPECT_THROW(search.Nearest(Eigen::Vector3f::Zero(), 1, &found), std::invalid_argument);
  EXPECT_THROW(search.Nearest(Eigen::Vector2f::Zero(), 0, &found), std::invalid_argument);
  EXPECT_THROW(search.Nearest(Eigen::Vector2f(0, std::nanf("")), 1, &found), std::invalid_argument);
  points(1, 1) = std::numeric_limits<float>::infinity();
  EXPECT_THROW(NeighbourSearch{points}, std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
