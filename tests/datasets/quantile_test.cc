#include "datasets/quantile.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace morphograph {
namespace {

TEST(Quantile, IsLinearBetweenNeighbours) {
  EXPECT_DOUBLE_EQ(Quantile({4, 1, 3, 2, 5}, 0.5), 3);
  EXPECT_DOUBLE_EQ(Quantile({4, 1, 3, 2, 5}, 1), 5);
  EXPECT_DOUBLE_EQ(Quantile({4, 1, 3, 2, 5}, 0.625), 3.5);
  EXPECT_THROW(Quantile({}, 0.5), std::invalid_argument);
  EXPECT_THROW(Quantile({1}, 1.5), std::invalid_argument);
}

TEST(Quantile, MedianIsBetweenTheTwoInTheMiddle) {
  EXPECT_DOUBLE_EQ(Median({4, 1, 3, 2}), 2.5);
  EXPECT_DOUBLE_EQ(Median({7}), 7);
}

}  // namespace
}  // namespace morphograph
