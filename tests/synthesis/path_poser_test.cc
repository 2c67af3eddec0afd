#include "synthesis/sensors/path_poser.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/olng_setting.h"

namespace morphograph {
namespace {

TEST(PathPoser, RefusesPathsThatAreNone) {
  const auto model = std::make_shared<OlngModel>(testing::OlngShared().base, OlngOptions());
  PathPoser poser(model);
  const Eigen::VectorXd reading = testing::OlngShared().Read(testing::OlngShared().known).col(0);
  EXPECT_THROW(poser.Next(reading, {}), std::invalid_argument);
  EXPECT_THROW(poser.Next(reading, {{.frame = -1}}), std::invalid_argument);
  EXPECT_THROW(poser.Next(reading, {{.frame = static_cast<int>(model->base().frame_count())}}), std::invalid_argument);
  EXPECT_THROW(poser.Next(reading.head(9), {{.frame = 0}}), std::invalid_argument);
  // The first and the last frame of the base: nothing comes before, or after.
  for (const TimeDirection direction : {TimeDirection::kForwards, TimeDirection::kBackwards}) {
    PathPoser at_the_ends(model, direction);
    for (int n = 0; n < 3; ++n)
      EXPECT_TRUE(at_the_ends.Next(reading, {{.frame = 0}, {.frame = static_cast<int>(model->base().frame_count()) - 1}}).rotations.allFinite());
  }
  OlngOptions nearest;
  nearest.pose = OlngPose::kNearest;
  EXPECT_THROW(PathPoser(std::make_shared<OlngModel>(testing::OlngShared().base, nearest)), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
