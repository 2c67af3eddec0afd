#include "datasets/clip_conversion.h"

#include <gtest/gtest.h>

#include "datasets/bvh_reader.h"
#include "datasets/bvh_writer.h"
#include "datasets/errors.h"
#include "datasets/forward_kinematics.h"
#include "tests/datasets/bvh_test_files.h"

namespace morphograph {
namespace {

double WorstDistance(const MotionClip& a, const MotionClip& b) {
  const std::vector<Eigen::Matrix3Xd> one = JointPositions(a), other = JointPositions(b);
  EXPECT_EQ(one.size(), other.size());
  double worst = 0;
  for (size_t f = 0; f < std::min(one.size(), other.size()); ++f) {
    worst = std::max(worst, (one[f] - other[f]).colwise().norm().maxCoeff());
  }
  return worst;
}

TEST(ClipConversion, BothOutputFormsReproduceThePoses) {
  const MotionClip clip = ImportClip(ParseBvh(testing::kSmallBvh, "small.bvh"));
  EXPECT_EQ(clip.name, "small");
  EXPECT_EQ(clip.frame_count(), 3);
  EXPECT_DOUBLE_EQ(clip.frame_rate_hz(), 120);
  EXPECT_DOUBLE_EQ(clip.skeleton().metres_per_unit(), 0.01);
  for (const bool source_channels : {false, true}) {
    const BvhDocument document = ExportClip(clip, {.source_channels = source_channels});
    EXPECT_EQ(document.channel_count(), source_channels ? 22 : 21);
    const MotionClip again = ImportClip(ParseBvh(WriteBvh(document), "again"));
    EXPECT_LT(WorstDistance(clip, again), 1e-7) << source_channels;
  }
}

TEST(ClipConversion, RefusesFrameTimesThatNobodyRecords) {
  BvhDocument document = ParseBvh(testing::kSmallBvh, "small.bvh");
  for (const double frame_time_s : {1e6, 1e4, 1.5, 0.0005, 1e-6}) {
    document.frame_time_s = frame_time_s;
    EXPECT_THROW(ImportClip(document), DatasetError) << frame_time_s;
  }
  for (const double frame_time_s : {1.0, 0.001}) {
    document.frame_time_s = frame_time_s;
    EXPECT_EQ(ImportClip(document).frame_count(), 3) << frame_time_s;
  }
}

}  // namespace
}  // namespace morphograph
