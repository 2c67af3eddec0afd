// Every real recording, read and written again.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "datasets/bvh_reader.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/contact_detector.h"
#include "datasets/dataset_loader.h"
#include "datasets/forward_kinematics.h"
#include "datasets/parallel_for.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

double WorstCoordinate(const MotionClip& a, const MotionClip& b) {
  double worst = a.frame_count() == b.frame_count() ? 0 : 1e9;
  WorldPose one, other;
  for (int f = 0; f < std::min(a.frame_count(), b.frame_count()); ++f) {
    ForwardKinematics(a.skeleton(), a.rotations(f), a.root_positions().col(f), &one);
    ForwardKinematics(b.skeleton(), b.rotations(f), b.root_positions().col(f), &other);
    worst = std::max(worst, (one.positions - other.positions).cwiseAbs().maxCoeff());
  }
  return worst;
}

void ExpectSameHierarchy(const BvhDocument& a, const BvhDocument& b) {
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].name, b.nodes[i].name);
    EXPECT_EQ(a.nodes[i].parent, b.nodes[i].parent);
    EXPECT_EQ(a.nodes[i].channels, b.nodes[i].channels);
    EXPECT_LT((a.nodes[i].offset - b.nodes[i].offset).norm(), 1e-5);
    EXPECT_EQ(a.nodes[i].end_site.has_value(), b.nodes[i].end_site.has_value());
  }
}

TEST(Recordings, ComeBackWithTheSameNamesValuesAndPositions) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::vector<std::filesystem::path> files = FindBvhFiles({testing::SharedData()});
  EXPECT_GE(files.size(), 426u);
  ParallelFor(2, static_cast<int>(files.size()), [&](int i) {
    SCOPED_TRACE(files[i].string());
    const BvhDocument document = ReadBvhFile(files[i]);
    const BvhDocument again = ParseBvh(WriteBvh(document), files[i].string());
    ExpectSameHierarchy(document, again);
    ASSERT_EQ(document.values.cols(), again.values.cols());
    EXPECT_LT((document.values - again.values).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_EQ(document.frame_time_s, again.frame_time_s);
    if (i % 3 != 0) return;  // every clip passes here in bvh_benchmark

    ClipImportReport report;
    const MotionClip clip = ImportClip(document, ClipImportOptions(), &report);
    ClipImportOptions fixed;
    fixed.drop_leading_rest = false;
    fixed.metres_per_unit = report.metres_per_unit;
    fixed.up_axis = report.up_axis;
    for (const bool source_channels : {false, true}) {
      ClipExportOptions options;
      options.source_channels = source_channels;
      const BvhDocument written = ParseBvh(WriteBvh(ExportClip(clip, options)), files[i].string());
      EXPECT_LT(WorstCoordinate(clip, ImportClip(written, fixed)), 1e-4) << source_channels;
      EXPECT_TRUE(!source_channels || written.channel_count() == document.channel_count());
    }
  });
}

// One skeleton has one heel, however somebody walks: what clips find of it, each from its own flat feet, agrees.
TEST(Recordings, HeelsOfOneSkeletonAgree) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  std::vector<MotionClip> clips;
  for (LoadedClip& loaded : LoadDataset({testing::SharedData() / "bnr" / "dataset-2" / "walk"}, DatasetManifest(), 2).clips) {
    if (loaded.clip.style == "exhausted") clips.push_back(std::move(loaded.clip));  // whose right heel lifts slowest
  }
  ASSERT_GE(clips.size(), 10u);
  Eigen::VectorXd lengths(clips.size());  // of the right foot, heel to ball
  ParallelFor(2, static_cast<int>(clips.size()), [&](int i) {
    const MotionClip& clip = clips[static_cast<size_t>(i)];
    const WorldPose pose = ForwardKinematics(clip, 0);
    const int ankle = clip.skeleton().roles()[JointRole::kRightAnkle];
    const Eigen::Vector3d heel = DetectContacts(clip).heels[1].col(0);
    const Eigen::Vector3d ball = pose.positions.col(clip.skeleton().roles()[JointRole::kRightToe]);
    lengths[i] = (heel - ball).norm();
  });
  EXPECT_GT(lengths.minCoeff(), 0.1);  // not the ankle, nor the ball
  const double spread = std::sqrt((lengths.array() - lengths.mean()).square().mean());
  EXPECT_LT(spread, 0.0007);
}

TEST(Recordings, UnitAxisRestRowsAndRolesAreFound) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  struct Expected {
    const char* file;
    double metres_per_unit;
    int dropped;
    double low_m, high_m;  // of the pelvis, in the mean
  };
  const double cmu = 0.0254 / 0.45;
  for (const Expected& expected : {
           Expected{"cmu/07/07_01.bvh", cmu, 1, 0.90, 1.01}, Expected{"cmu/07/07_12.bvh", cmu, 2, 0.90, 1.01},
           Expected{"cmu/09/09_10.bvh", cmu, 5, 0.90, 1.05}, Expected{"cmu/131/131_01.bvh", cmu, 0, 0.85, 0.96},
           Expected{"cmu/05/05_02.bvh", cmu, 1, 0.85, 1.01}, Expected{"cmu/03/03_01.bvh", cmu, 1, 1.0, 1.4},
           Expected{"cmu/06/06_02.bvh", cmu, 1, 0.90, 1.05},
           Expected{"bnr/dataset-2/walk/dataset-2_walk_normal_001.bvh", 0.01, 0, 0.86, 0.93},
           Expected{"bnr/dataset-2/run/dataset-2_run_feminine_001.bvh", 0.01, 0, 0.80, 0.95},
           Expected{"real_imu/neura_s02/S02-Trial-Walk-1_xsens.bvh", 0.001, 1, 0.93, 0.98}}) {
    SCOPED_TRACE(expected.file);
    ClipImportReport report;
    const MotionClip clip =
        ImportClip(ReadBvhFile(testing::SharedData() / expected.file), ClipImportOptions(), &report);
    EXPECT_DOUBLE_EQ(report.metres_per_unit, expected.metres_per_unit);
    EXPECT_EQ(report.up_axis, UpAxis::kY);
    EXPECT_EQ(report.dropped_frames, expected.dropped);
    EXPECT_GT(clip.root_positions().row(1).mean(), expected.low_m);
    EXPECT_LT(clip.root_positions().row(1).mean(), expected.high_m);
    EXPECT_TRUE(clip.skeleton().roles().Missing(EvaluationRoles()).empty());
    EXPECT_EQ(clip.frame_rate_hz(), std::round(clip.frame_rate_hz()));
  }
}

TEST(Recordings, ThePortableFormOfBnrCarriesThePositionOnTheFirstJoint) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const BvhDocument source =
      ReadBvhFile(testing::SharedData() / "bnr/dataset-2/walk/dataset-2_walk_normal_001.bvh");
  const MotionClip clip = ImportClip(source);
  const BvhDocument written = ExportClip(clip);
  EXPECT_EQ(written.nodes[0].name, "joint_Root");
  EXPECT_EQ(written.nodes[0].channels, source.nodes[0].channels);
  EXPECT_EQ(written.channel_count(), 6 + 21 * 3);
  for (int joint : {0, 1}) EXPECT_TRUE(written.nodes[joint].offset.isZero(0));
  for (int f = 0; f < clip.frame_count(); f += 7) {
    EXPECT_LT((written.values.col(f).head<3>() - source.values.col(f).segment<3>(6)).norm(), 1e-6);
    EXPECT_TRUE(written.values.col(f).segment<3>(3).isZero(0));
    EXPECT_LT((written.values.col(f).segment<3>(6) - source.values.col(f).segment<3>(9)).norm(), 1e-6);
  }
  ClipExportOptions options;
  options.source_channels = true;
  const BvhDocument same = ExportClip(clip, options);
  EXPECT_EQ(same.channel_count(), source.channel_count());
  EXPECT_LT((same.values.col(5).segment<3>(6) - source.values.col(5).segment<3>(6)).norm(), 1e-6);
  EXPECT_TRUE(same.values.col(5).head<6>().isZero(0));
}

}  // namespace
}  // namespace morphograph
