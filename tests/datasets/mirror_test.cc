#include "datasets/mirror.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/forward_kinematics.h"
#include "datasets/leg_ik.h"
#include "datasets/synthetic_gait.h"
#include "datasets/turn_between.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const Eigen::Matrix3d kReflection = Vector3d(-1, 1, 1).asDiagonal();

/// Largest distance between joints of `mirrored` and the reflected opposite joints of `clip`.
double WorstJoint(const MotionClip& clip, const MotionClip& mirrored, const MirrorMap& map, int stride = 7) {
  double worst = 0;
  for (int f = 0; f < clip.frame_count(); f += stride) {
    const WorldPose a = ForwardKinematics(clip, f), b = ForwardKinematics(mirrored, f);
    for (int j = 0; j < clip.joint_count(); ++j) {
      if (!clip.skeleton().IsBody(j) || map.pairs[j] < 0) continue;
      worst = std::max(worst, (kReflection * a.positions.col(j) - b.positions.col(map.pairs[j])).norm());
    }
  }
  return worst;
}

MotionClip TurningWalk() {
  SyntheticGaitOptions options;
  options.turns_rad = {0.25};
  options.seed = 5;
  options.frame_rate_hz = 30;
  return GenerateGait(options);
}

TEST(Mirror, PutsEveryJointWhereTheMirrorShowsTheOppositeOne) {
  const MotionClip clip = TurningWalk();
  const MirrorMap map = FindMirrorMap(clip);
  EXPECT_LT(WorstJoint(clip, Mirrored(clip, map), map), 1e-9);
}

TEST(Mirror, TwiceIsTheClipItself) {
  const MotionClip clip = TurningWalk();
  const MotionClip twice = Mirrored(Mirrored(clip));
  EXPECT_LT((twice.root_positions() - clip.root_positions()).cwiseAbs().maxCoeff(), 1e-12);
  for (int f = 0; f < clip.frame_count(); f += 5) {
    for (int j = 0; j < clip.joint_count(); ++j) ASSERT_LT(clip.rotation(f, j).angularDistance(twice.rotation(f, j)), 1e-6);
  }
}

TEST(Mirror, ExchangesLeftAndRightAndTurns) {
  const MotionClip clip = TurningWalk();
  const MotionClip mirrored = Mirrored(clip);
  const int last = clip.frame_count() - 1;
  EXPECT_NEAR(HeadingRad(mirrored, last), -HeadingRad(clip, last), 1e-9);
  EXPECT_NEAR(mirrored.root_positions()(0, last), -clip.root_positions()(0, last), 1e-12);
  EXPECT_EQ(mirrored.name, clip.name + "_mirrored");
}

/// The same motion on a skeleton whose left bones run along +X and right ones along -X in their own frames.
MotionClip WithTurnedBones(const MotionClip& clip) {
  const Skeleton& plain = clip.skeleton();
  std::vector<Joint> joints = plain.joints();
  std::vector<Quaterniond> turn(joints.size(), Quaterniond::Identity());  // plain joint frame from turned one
  for (size_t j = 1; j < joints.size(); ++j) {
    const bool left = joints[j].name.starts_with("Left"), right = joints[j].name.starts_with("Right");
    int child = -1;
    for (size_t c = j + 1; c < joints.size() && child < 0; ++c) {
      if (plain.parent(static_cast<int>(c)) == static_cast<int>(j)) child = static_cast<int>(c);
    }
    if ((left || right) && child > 0) {
      turn[j] = TurnBetween(left ? Vector3d::UnitX() : Vector3d(-Vector3d::UnitX()), plain.joint(child).offset_m);
    }
  }
  for (size_t j = 1; j < joints.size(); ++j) joints[j].offset_m = turn[joints[j].parent].conjugate() * joints[j].offset_m;
  const auto skeleton = std::make_shared<Skeleton>(joints, plain.roles(), 0.01, UpAxis::kY);
  MotionClip turned(skeleton, clip.frame_rate_hz(), clip.frame_count());
  turned.root_positions() = clip.root_positions();
  for (int f = 0; f < clip.frame_count(); ++f) {
    turned.rotation(f, 0) = clip.rotation(f, 0);
    for (size_t j = 1; j < joints.size(); ++j) {
      const int joint = static_cast<int>(j);
      turned.rotation(f, joint) = turn[joints[j].parent].conjugate() * clip.rotation(f, joint) * turn[j];
    }
  }
  return turned;
}

TEST(Mirror, WorksWhereTheTwoSidesDrawTheirAxesDifferently) {
  const MotionClip clip = WithTurnedBones(TurningWalk());
  const MirrorMap map = FindMirrorMap(clip);
  const MotionClip mirrored = Mirrored(clip, map);
  EXPECT_LT(WorstJoint(clip, mirrored, map), 1e-6);
  // Local rotations look like those of the other side, not turned about the bone by a right angle.
  for (int j = 1; j < clip.joint_count(); ++j) {
    for (int f = 0; f < clip.frame_count(); f += 11) {
      ASSERT_LT(mirrored.rotation(f, j).angularDistance(clip.rotation(f, j)), 1.5) << clip.skeleton().joint(j).name;
    }
  }
}

TEST(Mirror, NamesTheJointThatHasNoCounterpartInPlace) {
  const MotionClip clip = TurningWalk();
  std::vector<Joint> joints = clip.skeleton().joints();
  const int hand = clip.skeleton().Find("LeftHand");
  joints[hand].parent = clip.skeleton().Find("LeftArm");
  const auto skeleton = std::make_shared<Skeleton>(joints, clip.skeleton().roles(), 0.01, UpAxis::kY);
  EXPECT_THAT([&] { FindMirrorMap(MotionClip(skeleton, 30, 1)); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("LeftHand")));
}

TEST(Mirror, HoldsForRecordingsOfEveryDialect) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const auto data = testing::SharedData();
  std::vector<std::filesystem::path> files = {data / "cmu/07/07_01.bvh", data / "cmu/08/08_01.bvh", data / "cmu/131/131_01.bvh",
                                              data / "cmu/06/06_02.bvh", data / "real_imu/neura_s02/S02-Trial-Walk-1_xsens.bvh"};
  for (const char* style : {"normal", "active", "elderly", "exhausted", "feminine", "youthful"}) {
    files.push_back(data / "bnr/dataset-2/walk" / ("dataset-2_walk_" + std::string(style) + "_004.bvh"));
    files.push_back(data / "bnr/dataset-2/walk-turn-left" / ("dataset-2_walk-turn-left_" + std::string(style) + "_004.bvh"));
  }
  int checked = 0;
  for (const auto& file : files) {
    if (!std::filesystem::exists(file)) continue;
    ++checked;
    const MotionClip clip = ImportClip(ReadBvhFile(file));
    const MirrorMap map = FindMirrorMap(clip);
    const MotionClip mirrored = Mirrored(clip, map);
    const bool symmetric = file.string().find("bnr") != std::string::npos;
    // Bones of the two sides differ by up to 2.5 cm in cmu: joints are off by no more than that adds up to; feet are not off at all.
    EXPECT_LT(WorstJoint(clip, mirrored, map), symmetric ? 2e-3 : 0.10) << file;
    const RoleMap& roles = clip.skeleton().roles();
    double ankle = 0, backward = 0;
    const LegIk left(clip.skeleton(), Foot::kLeft), right(clip.skeleton(), Foot::kRight);
    for (int f = 0; f < clip.frame_count(); f += 7) {
      const WorldPose a = ForwardKinematics(clip, f), b = ForwardKinematics(mirrored, f);
      const Vector3d difference = kReflection * a.positions.col(roles[JointRole::kLeftAnkle]) - b.positions.col(roles[JointRole::kRightAnkle]);
      ankle = std::max(ankle, difference.norm());
      const double own = right.Measure(clip.root_positions().col(f), clip.rotations(f)).knee_bend_rad;
      backward = std::max(backward, std::min(own, 0.0) - left.Measure(mirrored.root_positions().col(f), mirrored.rotations(f)).knee_bend_rad);
    }
    EXPECT_LT(ankle, 0.012) << file;
    EXPECT_LT(backward, 0.02) << file;

    // The two sides' mean local rotations agree after mirroring: nothing is rolled about its bone.
    for (int j = 0; j < clip.joint_count(); ++j) {
      if (map.pairs[j] == j || map.pairs[j] < 0) continue;
      Eigen::Vector4d own = Eigen::Vector4d::Zero(), other = Eigen::Vector4d::Zero();
      for (int f = 0; f < clip.frame_count(); f += 7) {
        const Eigen::Vector4d p = clip.rotation(f, j).coeffs(), q = mirrored.rotation(f, j).coeffs();
        own += own.dot(p) < 0 ? Eigen::Vector4d(-p) : p;
        other += other.dot(q) < 0 ? Eigen::Vector4d(-q) : q;
      }
      EXPECT_GT(std::abs(own.normalized().dot(other.normalized())), 0.8) << file << " " << clip.skeleton().joint(j).name;
    }
  }
  EXPECT_GE(checked, 10);
}

}  // namespace
}  // namespace morphograph
