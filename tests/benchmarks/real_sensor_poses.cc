#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "datasets/augmentation.h"
#include "datasets/contact_detector.h"
#include "datasets/dataset_loader.h"
#include "datasets/quantile.h"
#include "datasets/sensor_alignment.h"
#include "datasets/stream_repair.h"
#include "graph/graph_builder.h"
#include "synthesis/sensors/motion_base.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/sensors/reconstruction.h"
#include "tests/benchmarks/real_sensors.h"

namespace morphograph {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr const char* kUsedSensors[] = {"L_Foot", "R_Foot", "L_LowLeg", "R_LowLeg", "Pelvis"};

// ---- how segments of two bodies correspond ----

// Directions of a segment of the body in the world, in columns: left, up, forwards. Pelvis: along the hip joints, and up. Shank: from ankle to knee, and forwards as the foot points.
Matrix3d PelvisAxes(const Vector3d& left_hip, const Vector3d& right_hip) {
  const Vector3d left = (left_hip - right_hip).normalized();
  const Vector3d up = (Vector3d::UnitY() - left.y() * left).normalized();
  Matrix3d axes;
  axes << left, up, left.cross(up);
  return axes;
}
Matrix3d ShankAxes(const Vector3d& knee, const Vector3d& ankle, const Vector3d& foot_forwards) {
  const Vector3d up = (knee - ankle).normalized(), left = up.cross(foot_forwards).normalized();
  Matrix3d axes;
  axes << left, up, left.cross(up);
  return axes;
}
// Of a foot that stands flat: up is up.
Matrix3d FlatFootAxes(const Vector3d& foot_forwards) {
  const Vector3d forwards = Vector3d(foot_forwards.x(), 0, foot_forwards.z()).normalized();
  Matrix3d axes;
  axes << Vector3d::UnitY().cross(forwards), Vector3d::UnitY(), forwards;
  return axes;
}

// How a segment's own frame lies in its body's directions, and where the joint that it hangs on is.
struct SegmentAnatomy {
  Matrix3d segment_from_body = Matrix3d::Zero();  // sums until Finish()
  Vector3d joint = Vector3d::Zero();              // in the segment's frame
  int samples = 0;

  void Add(const Matrix3d& world_from_segment, const Vector3d& origin, const Matrix3d& world_from_body, const Vector3d& world_joint) {
    segment_from_body += world_from_segment.transpose() * world_from_body;
    joint += world_from_segment.transpose() * (world_joint - origin);
    ++samples;
  }
  void Finish() {
    const Eigen::JacobiSVD<Matrix3d> svd(segment_from_body, Eigen::ComputeFullU | Eigen::ComputeFullV);
    segment_from_body = svd.matrixU() * svd.matrixV().transpose();
    joint /= samples;
  }
};

SegmentAnatomy AnatomyOf(const BodySensor& sensor, const NeuraRecording& neura, const SegmentMotion& segment) {
  const Readings& markers = neura.markers;
  const std::string joint = sensor.joint, side = joint.starts_with("left") ? "L" : "R";
  const auto at = [&](const std::string& name, int i) { return Vector3d(markers.values.col(i).segment<3>(RowOf(markers, name))); };
  SegmentAnatomy anatomy;
  // Feet lie flat while the person stands, before the walk.
  const bool foot = joint.ends_with("ankle");
  const int first = foot ? 50 : neura.walk_first, last = foot ? neura.walk_first - 50 : neura.walk_last;
  for (int i = first; i <= last; ++i) {
    const Matrix3d& world_from_segment = segment.rotations[static_cast<std::size_t>(i)];
    const Vector3d origin = segment.positions.col(i);
    if (joint == "hips") {
      anatomy.Add(world_from_segment, origin, PelvisAxes(at("LHJC", i), at("RHJC", i)), (at("LHJC", i) + at("RHJC", i)) / 2);
      continue;
    }
    const Vector3d forwards = at(side + "TOE", i) - at(side + "HEE", i);
    if (foot) anatomy.Add(world_from_segment, origin, FlatFootAxes(forwards), at(side + "AJC", i));
    else anatomy.Add(world_from_segment, origin, ShankAxes(at(side + "KJC", i), at(side + "AJC", i), forwards), at(side + "KJC", i));
  }
  anatomy.Finish();
  return anatomy;
}

SegmentAnatomy AnatomyOf(const std::string& joint_name, const std::vector<MotionClip>& clips) {
  constexpr std::size_t kEvery = 8;  // clips enough for a mean
  const Skeleton& skeleton = clips.front().skeleton();
  const RoleMap& roles = skeleton.roles();
  const int joint = skeleton.FindRoleOrName(joint_name);
  const bool left = joint_name.starts_with("left"), foot = joint_name.ends_with("ankle");
  const int knee = roles[left ? JointRole::kLeftKnee : JointRole::kRightKnee], ankle = roles[left ? JointRole::kLeftAnkle : JointRole::kRightAnkle];
  const int toe = roles[left ? JointRole::kLeftToe : JointRole::kRightToe];
  SegmentAnatomy anatomy;
  for (std::size_t c = 0; c < clips.size(); c += kEvery) {
    const MotionClip& clip = clips[c];
    const ContactTrack contacts = DetectContacts(clip);
    for (int f = 0; f < clip.frame_count(); ++f) {
      const WorldPose pose = ForwardKinematics(clip, f);
      const Matrix3d world_from_joint = pose.rotations[static_cast<std::size_t>(joint)].toRotationMatrix();
      const Vector3d origin = pose.positions.col(joint);
      if (joint_name == "hips") {
        const Vector3d left_hip = pose.positions.col(roles[JointRole::kLeftHip]), right_hip = pose.positions.col(roles[JointRole::kRightHip]);
        anatomy.Add(world_from_joint, origin, PelvisAxes(left_hip, right_hip), (left_hip + right_hip) / 2);
        continue;
      }
      const Vector3d forwards = pose.positions.col(toe) - pose.positions.col(ankle);
      if (!foot) anatomy.Add(world_from_joint, origin, ShankAxes(pose.positions.col(knee), pose.positions.col(ankle), forwards), origin);
      else if (contacts.planted(left ? 0 : 2, f) && contacts.planted(left ? 1 : 3, f)) anatomy.Add(world_from_joint, origin, FlatFootAxes(forwards), origin);
    }
  }
  anatomy.Finish();
  return anatomy;
}

// Where the sensor sits on the model's body, by where it sits on the person's.
Placement PlacementOf(const BodySensor& sensor, const SensorAlignment& alignment, const SegmentAnatomy& person, const SegmentAnatomy& model, double scale) {
  Placement placement{sensor.name, sensor.joint};
  const Matrix3d model_from_person = model.segment_from_body * person.segment_from_body.transpose();
  placement.joint_from_sensor = Eigen::Quaterniond(Matrix3d(model_from_person * alignment.segment_from_sensor.toRotationMatrix()));
  placement.offset_m = model.joint + scale * (model_from_person * (alignment.offset_m - person.joint));
  return placement;
}

// ---- errors ----

using LegJoints = Eigen::Matrix<double, 3, 6>;   // hips, knees, ankles, left before right
using LegPlaces = Eigen::Matrix<double, 3, 4>;   // knees and ankles from the middle of the hips: left, up, forwards of the hips

const char* const kJointCentres[] = {"LHJC", "RHJC", "LKJC", "RKJC", "LAJC", "RAJC"};
const JointRole kLegRoles[] = {JointRole::kLeftHip, JointRole::kRightHip, JointRole::kLeftKnee, JointRole::kRightKnee, JointRole::kLeftAnkle, JointRole::kRightAnkle};

double LegLength(const LegJoints& joints) {
  double length = 0;
  for (int side = 0; side < 2; ++side) length += ((joints.col(side) - joints.col(2 + side)).norm() + (joints.col(2 + side) - joints.col(4 + side)).norm()) / 2;
  return length;
}

// For legs of `length_m`.
LegPlaces PlacesOfLegs(const LegJoints& joints, double length_m) {
  const Vector3d middle = (joints.col(0) + joints.col(1)) / 2;
  Vector3d left = joints.col(0) - joints.col(1);
  left.y() = 0;
  left.normalize();
  Matrix3d axes;
  axes << left, Vector3d::UnitY(), left.cross(Vector3d::UnitY());
  return length_m / LegLength(joints) * (axes.transpose() * (joints.rightCols<4>().colwise() - middle));
}

std::vector<LegPlaces> PlacesOfLegs(const MotionClip& clip, double length_m) {
  std::vector<LegPlaces> places;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const WorldPose pose = ForwardKinematics(clip, f);
    LegJoints joints;
    for (int j = 0; j < 6; ++j) joints.col(j) = pose.positions.col(clip.skeleton().roles()[kLegRoles[j]]);
    places.push_back(PlacesOfLegs(joints, length_m));
  }
  return places;
}

double Rms_cm(const LegPlaces& off) { return 100 * std::sqrt(off.colwise().squaredNorm().mean()); }

LegPlaces MeanOf(const std::vector<LegPlaces>& places) {
  LegPlaces mean = LegPlaces::Zero();
  for (const LegPlaces& place : places) mean += place / static_cast<double>(places.size());
  return mean;
}

void PrintErrors(const std::string& name, const std::vector<LegPlaces>& found, const std::vector<LegPlaces>& truth) {
  const std::size_t frames = std::min(found.size(), truth.size());
  std::vector<LegPlaces> off;
  for (std::size_t f = 0; f < frames; ++f) off.push_back(found[f] - truth[f]);
  const LegPlaces constant = MeanOf(off);
  std::vector<double> errors, moving;
  double mean = 0, moving_mean = 0;
  for (const LegPlaces& o : off) {
    errors.push_back(Rms_cm(o));
    moving.push_back(Rms_cm(o - constant));
    mean += errors.back() / static_cast<double>(frames);
    moving_mean += moving.back() / static_cast<double>(frames);
  }
  std::printf("  %-56s %6.2f %6.2f %10.2f %6.2f\n", name.c_str(), mean, Quantile(errors, 0.95), moving_mean, Quantile(moving, 0.95));
  std::fflush(stdout);
}

// ---- the base ----

std::shared_ptr<const MotionGraph> Train(const std::filesystem::path& bnr) {
  std::vector<MotionClip> clips;
  for (const LoadedClip& loaded : LoadDataset({bnr / "walk", bnr / "walk-turn-left", bnr / "walk-turn-right"}).clips) clips.push_back(loaded.clip);
  std::vector<TrainingClip> training;
  for (AugmentedClip& level : Augment(clips, {})) {
    if (!level.made) training.push_back({std::move(level.clip), false, static_cast<int>(training.size())});
  }
  TrainingOptions options;
  options.keep_recordings = true;
  options.jobs = 2;
  return BuildGraph(training, options);
}

// Of every true pose the pose of the base that is nearest: what no choice of one can better.
std::vector<LegPlaces> NearestPoses(const std::vector<MotionClip>& clips, const std::vector<LegPlaces>& truth, double length_m) {
  std::vector<LegPlaces> base;
  for (const MotionClip& clip : clips) {
    for (const LegPlaces& place : PlacesOfLegs(clip, length_m)) base.push_back(place);
  }
  Eigen::MatrixXf columns(12, static_cast<Eigen::Index>(base.size()));
  for (std::size_t i = 0; i < base.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = base[i].reshaped().cast<float>();
  std::vector<LegPlaces> nearest;
  for (const LegPlaces& place : truth) {
    Eigen::Index best = 0;
    (columns.colwise() - Eigen::VectorXf(place.reshaped().cast<float>())).colwise().squaredNorm().minCoeff(&best);
    nearest.push_back(base[static_cast<std::size_t>(best)]);
  }
  return nearest;
}

Readings Part(const Readings& readings, double from_s, double to_s) {
  const auto first = static_cast<Eigen::Index>(std::lround(from_s * kReconstructionRate_hz));
  const auto last = std::min<Eigen::Index>(std::lround(to_s * kReconstructionRate_hz), readings.sample_count() - 1);
  Readings part = readings;
  part.values = readings.values.middleCols(first, last - first + 1).eval();
  part.times_s.assign(readings.times_s.begin() + first, readings.times_s.begin() + last + 1);
  return part;
}

}  // namespace

void PrintPoses(const std::filesystem::path& data, const NeuraRecording& neura) {
  const std::shared_ptr<const MotionGraph> graph = Train(data / "bnr/dataset-2");
  const MotionSource source = SourceOf(*graph, 2);

  StreamRepairOptions at_rate;
  at_rate.rate_hz = kReconstructionRate_hz;
  at_rate.kind = ReadingsKind::kMarkers;
  const Readings markers = RepairStream(neura.markers, at_rate).readings;
  double length_m = 0;
  std::vector<LegPlaces> truth;
  for (const bool measure : {true, false}) {
    for (int i = 0; i < markers.sample_count(); ++i) {
      LegJoints joints;
      for (int j = 0; j < 6; ++j) joints.col(j) = markers.values.col(i).segment<3>(RowOf(markers, kJointCentres[j]));
      if (measure) length_m += LegLength(joints) / markers.sample_count();
      else truth.push_back(PlacesOfLegs(joints, length_m));
    }
  }

  // What was read, what perfect sensors in the same places would have read, and where these are on the model's body.
  Readings real, simulated;
  const int samples = neura.sensors.sample_count();
  real.values.resize(3 * static_cast<Eigen::Index>(std::size(kUsedSensors)), samples);
  simulated.values = real.values;
  std::vector<Placement> placements;
  const WorldPose model_pose = ForwardKinematics(source.clips.front(), 0);
  LegJoints model_legs;
  for (int j = 0; j < 6; ++j) model_legs.col(j) = model_pose.positions.col(graph->skeleton().roles()[kLegRoles[j]]);
  const double scale = LegLength(model_legs) / length_m;
  for (const char* name : kUsedSensors) {
    const BodySensor& sensor = *std::find_if(BodySensors().begin(), BodySensors().end(), [&](const BodySensor& s) { return s.name == std::string(name); });
    const auto row = 3 * static_cast<Eigen::Index>(placements.size());
    const SegmentMotion segment = SegmentFromMarkers(neura.markers, sensor.markers);
    const Matrix3Xd readings = neura.sensors.values.middleRows<3>(RowOf(neura.sensors, sensor.name));
    const SensorAlignment alignment = AlignSensor(segment, readings);
    const int delay = std::max(0, alignment.delay_samples);
    real.values.middleRows<3>(row) << readings.rightCols(samples - delay), readings.rightCols(1).replicate(1, delay);
    simulated.values.middleRows<3>(row) = ReadingsOf(segment, alignment, 15);
    placements.push_back(PlacementOf(sensor, alignment, AnatomyOf(sensor, neura, segment), AnatomyOf(sensor.joint, source.clips), scale));
    real.names.emplace_back(sensor.name);
    std::printf("    %-10s on the model: offset %5.2f %5.2f %5.2f m\n", name, placements.back().offset_m.x(), placements.back().offset_m.y(), placements.back().offset_m.z());
  }
  real.times_s = neura.sensors.times_s;
  simulated.names = real.names;
  simulated.times_s = real.times_s;
  at_rate.kind = ReadingsKind::kAccelerations;
  const Readings real_30 = RepairStream(real, at_rate).readings, simulated_30 = RepairStream(simulated, at_rate).readings;

  std::printf("\nPoses from 5 sensors (feet, shanks, pelvis), model: bnr walks and turns. Knees and ankles against the marker joint centres, seen from the middle of the hips, legs of %.2f m (model: %.2f)\n"
              "  %-56s %6s %6s %10s %6s\n", length_m, LegLength(model_legs), "", "cm", "95 %", "moving cm", "95 %");
  const double walk_from_s = neura.walk_first / 100.0, walk_to_s = neura.walk_last / 100.0;
  const auto part_of = [&](double from_s, double to_s) {
    const auto first = std::lround(from_s * kReconstructionRate_hz), last = std::min<long>(std::lround(to_s * kReconstructionRate_hz), static_cast<long>(truth.size()) - 1);
    return std::vector<LegPlaces>(truth.begin() + first, truth.begin() + last + 1);
  };
  struct Span {
    const char* name;
    double from_s, to_s;
  };
  double first_strike_s = walk_to_s, last_strike_s = walk_from_s;
  for (const auto& [label, times] : neura.strikes_s) {
    if (!label.ends_with("strike")) continue;  // else where the person stands
    for (const double time : times) first_strike_s = std::min(first_strike_s, time), last_strike_s = std::max(last_strike_s, time);
  }
  const Span spans[] = {{"first to last strike", first_strike_s, last_strike_s}, {"walking", walk_from_s, walk_to_s}, {"whole, with 15 s of standing", 0, 1e3}};
  for (const Span& span : spans) {
    const std::vector<LegPlaces> there = part_of(span.from_s, span.to_s);
    PrintErrors(std::string(span.name) + ": the person's own mean pose", std::vector<LegPlaces>(there.size(), MeanOf(there)), there);
    PrintErrors(std::string(span.name) + ": the model's nearest pose (a bound)", NearestPoses(source.clips, there, length_m), there);
    for (const ReconstructionMethod method : {ReconstructionMethod::kOlng, ReconstructionMethod::kGraph}) {
      const auto reconstructor = MakeReconstructor(graph, method, placements, 2);
      for (const auto& [name, readings] : {std::pair<const char*, const Readings*>{"real sensors", &real_30}, {"simulated sensors", &simulated_30}}) {
        const Reconstruction made = reconstructor->Run(Part(*readings, span.from_s, span.to_s).values);
        PrintErrors(std::string(span.name) + ": " + std::string(MethodName(method)) + ", " + name, PlacesOfLegs(made.clip, length_m), there);
      }
    }
  }
}

}  // namespace morphograph
