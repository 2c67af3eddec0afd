// A walk written Z up, as some exporters do, is the same walk.
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/bvh_reader.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/forward_kinematics.h"
#include "datasets/manifest.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

// A point (x, y, z) with Y up is (x, -z, y) with Z up.
Eigen::Vector3d ZUp(const Eigen::Vector3d& v) { return {v.x(), -v.z(), v.y()}; }

// The file that a Z-up program would have written, made without the code under test: X stays X, Y becomes Z, Z becomes
// -Y, so a turn about Z by some angle is one about Y by its negative. The order in which channels stand is kept.
BvhDocument ZUp(const BvhDocument& y_up) {
  BvhDocument z_up = y_up;
  for (BvhDocument::Node& node : z_up.nodes) {
    node.offset = ZUp(node.offset);
    if (node.end_site) node.end_site = ZUp(*node.end_site);
    for (size_t c = 0; c < node.channels.size(); ++c) {
      const Eigen::Index row = node.first_channel + static_cast<Eigen::Index>(c);
      switch (node.channels[c]) {
        case Channel::kYPosition: node.channels[c] = Channel::kZPosition; break;
        case Channel::kYRotation: node.channels[c] = Channel::kZRotation; break;
        case Channel::kZPosition: node.channels[c] = Channel::kYPosition; z_up.values.row(row) *= -1; break;
        case Channel::kZRotation: node.channels[c] = Channel::kYRotation; z_up.values.row(row) *= -1; break;
        default: break;
      }
    }
  }
  return z_up;
}

MotionClip CurvedWalk() {
  SyntheticGaitOptions options;
  options.steps = 8;
  options.turns_rad = {0.1, -0.2, 0.3};
  options.heading_rad = 0.7;
  return GenerateGait(options);
}

void ExpectSameMotion(const MotionClip& one, const MotionClip& other, double tolerance) {
  ASSERT_EQ(one.frame_count(), other.frame_count());
  ASSERT_EQ(one.joint_count(), other.joint_count());
  double worst_m = 0, worst_turn = 0;
  for (int f = 0; f < one.frame_count(); ++f) {
    const WorldPose a = ForwardKinematics(one, f), b = ForwardKinematics(other, f);
    worst_m = std::max(worst_m, (a.positions - b.positions).cwiseAbs().maxCoeff());
    for (size_t j = 0; j < a.rotations.size(); ++j) {
      worst_turn = std::max(worst_turn, (a.rotations[j].toRotationMatrix() - b.rotations[j].toRotationMatrix()).norm());
    }
  }
  EXPECT_LT(worst_m, tolerance);
  EXPECT_LT(worst_turn, tolerance);
}

class ZUpImport : public ::testing::TestWithParam<bool> {};

TEST_P(ZUpImport, GivesTheSameMotionAsTheYUpFile) {
  const BvhDocument y_up = ExportClip(CurvedWalk(), {.metres_per_unit = 0.01});
  const BvhDocument z_up = ParseBvh(WriteBvh(ZUp(y_up), {.decimals = 9}), "z_up.bvh");
  ClipImportOptions options;
  if (GetParam()) {  // told, else found
    options = ParseManifest(R"({"up_axis": "Z", "metres_per_unit": 0.01})", "set.json").import;
  }
  ClipImportReport report;
  const MotionClip clip = ImportClip(z_up, options, &report);
  EXPECT_EQ(report.up_axis, UpAxis::kZ);
  EXPECT_DOUBLE_EQ(report.metres_per_unit, 0.01);
  EXPECT_EQ(clip.skeleton().up_axis(), UpAxis::kZ);
  const MotionClip reference = ImportClip(y_up);
  EXPECT_EQ(reference.skeleton().up_axis(), UpAxis::kY);
  for (int j = 0; j < clip.joint_count(); ++j) {
    EXPECT_LT((clip.skeleton().joint(j).offset_m - reference.skeleton().joint(j).offset_m).norm(), 1e-9);
  }
  ExpectSameMotion(reference, clip, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(ToldOrFound, ZUpImport, ::testing::Bool(),
                         [](const auto& told) { return told.param ? "Told" : "Found"; });

TEST(ZUp, AClipGoesOutAsItCameIn) {
  const BvhDocument z_up = ZUp(ExportClip(CurvedWalk(), {.metres_per_unit = 0.01}));
  const BvhDocument again = ExportClip(ImportClip(z_up));
  ASSERT_EQ(again.nodes.size(), z_up.nodes.size());
  for (size_t j = 0; j < z_up.nodes.size(); ++j) {
    EXPECT_EQ(again.nodes[j].name, z_up.nodes[j].name);
    if (j == 0) continue;  // a root's OFFSET is written as zero
    EXPECT_LT((again.nodes[j].offset - z_up.nodes[j].offset).norm(), 1e-9) << again.nodes[j].name;
  }
  // Z stands for height in the file.
  EXPECT_GT(again.values.row(2).minCoeff(), 70);
  ExpectSameMotion(ImportClip(z_up), ImportClip(again), 1e-8);
}

}  // namespace
}  // namespace morphograph
