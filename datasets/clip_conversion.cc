#include "datasets/clip_conversion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "datasets/body_measures.h"
#include "datasets/errors.h"
#include "datasets/euler.h"
#include "datasets/forward_kinematics.h"
#include "datasets/quantile.h"
#include "datasets/rest_frames.h"
#include "datasets/text_encoding.h"

namespace morphograph {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
// Larger numbers are no motion, and their squares must not leave the range of a double.
constexpr double kLargestValue = 1e12;
// Nobody records motion below one frame a second or above a thousand; a slower file would claim hours, and every measure at
// 30 fps would work through them.
constexpr double kShortestFrame_s = 1e-3;
constexpr double kLongestFrame_s = 1;

bool IsPosition(Channel channel) { return static_cast<int>(channel) < 3; }
int Axis(Channel channel) { return static_cast<int>(channel) % 3; }

bool HasPosition(const std::vector<Channel>& channels) {
  return std::any_of(channels.begin(), channels.end(), IsPosition);
}

// Axes of the rotation channels, in file order.
std::vector<int> RotationAxes(const std::vector<Channel>& channels) {
  std::vector<int> axes;
  for (const Channel channel : channels) {
    if (!IsPosition(channel)) axes.push_back(Axis(channel));
  }
  return axes;
}

// A full order that starts with the given axes; Z X Y, the commonest in BVH, where there are none.
EulerOrder CompleteOrder(const std::vector<int>& axes) {
  EulerOrder order = {};
  size_t count = 0;
  for (const int axis : axes) order[count++] = axis;
  for (const int axis : {2, 0, 1}) {
    if (std::find(axes.begin(), axes.end(), axis) == axes.end() && count < 3) order[count++] = axis;
  }
  return order;
}

// z up -> y up: a quarter turn about X, (x, y, z) -> (x, z, -y).
const Eigen::Quaterniond& YUpFromZUp() {
  static const Eigen::Quaterniond turn(Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  return turn;
}

// ---- import ----

Eigen::Quaterniond LocalRotation(const BvhDocument& document, int joint, int frame) {
  const BvhDocument::Node& node = document.nodes[joint];
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  for (size_t c = 0; c < node.channels.size(); ++c) {
    if (IsPosition(node.channels[c])) continue;
    const double half = 0.5 * kRadians * document.values(node.first_channel + static_cast<int>(c), frame);
    Eigen::Quaterniond turn(std::cos(half), 0, 0, 0);
    turn.vec()[Axis(node.channels[c])] = std::sin(half);
    rotation = rotation * turn;
  }
  return rotation;
}

// From the parent, source units: position channels replace the OFFSET.
Eigen::Vector3d LocalPosition(const BvhDocument& document, int joint, int frame) {
  const BvhDocument::Node& node = document.nodes[joint];
  Eigen::Vector3d position = node.offset;
  for (size_t c = 0; c < node.channels.size(); ++c) {
    if (!IsPosition(node.channels[c])) continue;
    position[Axis(node.channels[c])] = document.values(node.first_channel + static_cast<int>(c), frame);
  }
  return position;
}

// Offset of a bone, and how far its position channels stray from it.
Eigen::Vector3d BoneOffset(const BvhDocument& document, int joint, int first_frame, double* stray) {
  const BvhDocument::Node& node = document.nodes[joint];
  Eigen::Vector3d offset = node.offset;
  *stray = 0;
  std::vector<double> values;
  for (size_t c = 0; c < node.channels.size(); ++c) {
    if (!IsPosition(node.channels[c])) continue;
    values.clear();
    for (int f = first_frame; f < document.frame_count(); ++f) {
      values.push_back(document.values(node.first_channel + static_cast<int>(c), f));
    }
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const double spread = *high - *low;
    *stray = std::max(*stray, spread);
    offset[Axis(node.channels[c])] = Median(values);
  }
  return offset;
}

void CheckValues(const BvhDocument& document) {
  if (document.nodes.empty()) throw DatasetError(document.source, "no joints");
  if (document.frame_count() == 0) throw DatasetError(document.source, "no frames");
  const auto bad = [](const auto& values) { return !values.allFinite() || values.cwiseAbs().maxCoeff() > kLargestValue; };
  for (const BvhDocument::Node& node : document.nodes) {
    if (bad(node.offset) || (node.end_site && bad(*node.end_site))) {
      throw DatasetError(document.source, "OFFSET of joint '" + node.name + "' is too large for a body");
    }
  }
  if (document.channel_count() > 0 && bad(document.values)) {
    throw DatasetError(document.source, "a frame holds a value that is too large for a motion");
  }
  if (!(document.frame_time_s >= kShortestFrame_s && document.frame_time_s <= kLongestFrame_s)) {
    throw DatasetError(document.source, "frame time " + std::to_string(document.frame_time_s) +
                                            " s is none of motion capture: 0.001 to 1 s are read");
  }
}

bool IsBelow(const BvhDocument& document, int joint, int ancestor) {
  while (joint > ancestor) joint = document.nodes[joint].parent;
  return joint == ancestor;
}

// A limb's joints hang below each other. Where names pretend otherwise, a role that was only guessed is taken back.
void CheckLimbs(const BvhDocument& document, const std::map<std::string, std::string>& overrides, RoleMap* roles) {
  constexpr std::pair<JointRole, JointRole> kLimbs[] = {
      {JointRole::kHips, JointRole::kLeftHip},           {JointRole::kLeftHip, JointRole::kLeftKnee},
      {JointRole::kLeftKnee, JointRole::kLeftAnkle},     {JointRole::kLeftAnkle, JointRole::kLeftToe},
      {JointRole::kHips, JointRole::kRightHip},          {JointRole::kRightHip, JointRole::kRightKnee},
      {JointRole::kRightKnee, JointRole::kRightAnkle},   {JointRole::kRightAnkle, JointRole::kRightToe},
      {JointRole::kLeftShoulder, JointRole::kLeftElbow}, {JointRole::kLeftElbow, JointRole::kLeftWrist},
      {JointRole::kRightShoulder, JointRole::kRightElbow}, {JointRole::kRightElbow, JointRole::kRightWrist}};
  for (const auto& [upper, lower] : kLimbs) {
    if (!roles->Has(upper) || !roles->Has(lower)) continue;
    if ((*roles)[lower] != (*roles)[upper] && IsBelow(document, (*roles)[lower], (*roles)[upper])) continue;
    if (overrides.contains(std::string(RoleName(lower)))) {
      throw DatasetError(document.source, "role '" + std::string(RoleName(lower)) + "' is given to joint '" +
                                              document.nodes[(*roles)[lower]].name + "', which is not below '" +
                                              document.nodes[(*roles)[upper]].name + "' (" +
                                              std::string(RoleName(upper)) + ")");
    }
    roles->Set(lower, -1);
  }
}

RoleMap FindRoles(const BvhDocument& document, const std::map<std::string, std::string>& overrides) {
  std::vector<std::string> names;
  for (const BvhDocument::Node& node : document.nodes) names.push_back(node.name);
  RoleMap roles = DetectRoles(names);
  for (const auto& [role_name, joint_name] : overrides) {
    const std::optional<JointRole> role = RoleFromName(role_name);
    if (!role) throw DatasetError(document.source, "'" + role_name + "' is no joint role");
    const auto joint = std::find(names.begin(), names.end(), joint_name);
    if (joint == names.end()) {
      throw DatasetError(document.source, "role '" + role_name + "' is given to joint '" + joint_name +
                                              "', which the file does not have");
    }
    roles.Set(*role, static_cast<int>(joint - names.begin()));
  }
  CheckLimbs(document, overrides, &roles);
  return roles;
}

// Written frame times are rounded: 0.0083333 means 120 Hz, 0.033367 means 30000/1001 Hz.
double FrameRate(double frame_time_s) {
  const double rate = 1 / frame_time_s;
  for (const double known : {std::round(rate), std::round(rate * 1.001) / 1.001}) {
    if (known >= 1 && std::abs(rate / known - 1) < 1e-4) return known;
  }
  return rate;
}

void AddNote(std::string* note, const std::string& text) {
  if (!note->empty()) *note += "; ";
  *note += text;
}

// The clip in source units and axes, rest rows included.
MotionClip SourceClip(const BvhDocument& document, std::shared_ptr<const Skeleton> skeleton) {
  const int root = skeleton->moving_root();
  std::vector<int> above;  // joints above the moving root, first joint first
  for (int j = document.nodes[root].parent; j >= 0; j = document.nodes[j].parent) above.insert(above.begin(), j);
  MotionClip clip(skeleton, FrameRate(document.frame_time_s), document.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = 0; j < clip.joint_count(); ++j) clip.rotation(f, j) = LocalRotation(document, j, f);
    Eigen::Quaterniond world = Eigen::Quaterniond::Identity();
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    for (const int j : above) {
      position += world * LocalPosition(document, j, f);
      world = world * clip.rotation(f, j);
      clip.rotation(f, j).setIdentity();
    }
    clip.root_positions().col(f) = position + world * LocalPosition(document, root, f);
    clip.rotation(f, root) = world * clip.rotation(f, root);
    // One hemisphere in time, so that neighbouring frames can be interpolated component by component.
    for (int j = 0; j < clip.joint_count(); ++j) {
      Eigen::Quaterniond& rotation = clip.rotation(f, j);
      rotation.normalize();
      if (f > 0 && rotation.dot(clip.rotation(f - 1, j)) < 0) rotation.coeffs() *= -1;
    }
  }
  return clip;
}

// Joints with offsets in source units and axes; those of the moving root and of the joints above it are zero.
std::vector<Joint> SourceJoints(const BvhDocument& document, int moving_root, int first_frame,
                                std::vector<double>* strays) {
  std::vector<char> above(document.nodes.size(), 0);
  for (int j = moving_root; j >= 0; j = document.nodes[j].parent) above[j] = 1;
  std::vector<Joint> joints;
  strays->assign(document.nodes.size(), 0);
  for (int j = 0; j < static_cast<int>(document.nodes.size()); ++j) {
    const BvhDocument::Node& node = document.nodes[j];
    Joint joint{node.name, node.parent, Eigen::Vector3d::Zero(), node.end_site, node.channels};
    if (!above[j]) joint.offset_m = BoneOffset(document, j, first_frame, &(*strays)[j]);
    joints.push_back(std::move(joint));
  }
  return joints;
}

std::shared_ptr<const Skeleton> MakeSkeleton(const BvhDocument& document, std::vector<Joint> joints,
                                             const RoleMap& roles, double metres_per_unit, UpAxis up_axis) {
  try {
    return std::make_shared<const Skeleton>(std::move(joints), roles, metres_per_unit, up_axis);
  } catch (const std::invalid_argument& error) {
    throw DatasetError(document.source, error.what());
  }
}

}  // namespace

MotionClip ImportClip(const BvhDocument& document, const ClipImportOptions& options, ClipImportReport* report) {
  CheckValues(document);
  const RoleMap roles = FindRoles(document, options.roles);
  const int moving_root = roles.Has(JointRole::kHips) ? roles[JointRole::kHips] : 0;
  ClipImportReport found;
  std::vector<double> strays;

  MotionClip source = SourceClip(
      document, MakeSkeleton(document, SourceJoints(document, moving_root, 0, &strays), roles, 1, UpAxis::kY));
  found.dropped_frames = options.drop_leading_rest ? CountLeadingRestFrames(source) : 0;
  if (found.dropped_frames > 0) {
    source = source.Slice(found.dropped_frames, source.frame_count() - found.dropped_frames);
    AddNote(&found.note, "dropped " + std::to_string(found.dropped_frames) + " leading rest frame" +
                             (found.dropped_frames > 1 ? "s" : ""));
  }

  std::vector<Joint> joints = SourceJoints(document, moving_root, found.dropped_frames, &strays);
  const auto provisional = MakeSkeleton(document, joints, roles, 1, UpAxis::kY);
  const BodyMeasures measures = MeasureBody(source, *provisional);
  found.up_axis = options.up_axis.value_or(measures.up_axis);
  found.metres_per_unit = options.metres_per_unit.value_or(measures.metres_per_unit);
  if (!(found.metres_per_unit > 0) || !std::isfinite(found.metres_per_unit)) {
    throw DatasetError(document.source, "metres per unit must be positive");
  }
  if (!options.metres_per_unit && !measures.unit_note.empty()) AddNote(&found.note, measures.unit_note);
  if (!options.up_axis && !measures.up_note.empty()) AddNote(&found.note, measures.up_note);

  if (document.names_transcoded) AddNote(&found.note, "joint names are no UTF-8; read as Latin-1, written as UTF-8");

  constexpr double kRigid_m = 0.002;
  int strayed = 0;
  for (const double stray : strays) strayed += stray * found.metres_per_unit > kRigid_m;
  if (strayed > 0) {
    AddNote(&found.note, std::to_string(strayed) + " bone" + (strayed > 1 ? "s vary" : " varies") +
                             " in length; the median is kept");
  }

  const bool turned = found.up_axis == UpAxis::kZ;
  const Eigen::Quaterniond turn = turned ? YUpFromZUp() : Eigen::Quaterniond::Identity();
  for (Joint& joint : joints) {
    joint.offset_m = turn * joint.offset_m * found.metres_per_unit;
    if (joint.end_site_m) joint.end_site_m = turn * *joint.end_site_m * found.metres_per_unit;
  }
  MotionClip clip(MakeSkeleton(document, std::move(joints), roles, found.metres_per_unit, found.up_axis),
                  source.frame_rate_hz(), source.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = 0; j < clip.joint_count(); ++j) {
      clip.rotation(f, j) = turned ? turn * source.rotation(f, j) * turn.conjugate() : source.rotation(f, j);
    }
    clip.root_positions().col(f) = turn * source.root_positions().col(f) * found.metres_per_unit;
  }
  clip.name = Utf8FromUnknown(std::filesystem::path(document.source).stem().string());
  if (report) *report = found;
  return clip;
}

// ---- export ----

namespace {

// How the rotation of one joint is written.
struct RotationLayout {
  EulerOrder order;
  std::array<int, 3> rows = {-1, -1, -1};  // value row of each of the order's axes, -1: not written
  int axes = 0;
};

// A rotation that one or two channels have to stand for: the nearest about one axis; for two, the third angle
// is left out.
void WriteReduced(const Eigen::Quaterniond& rotation, const RotationLayout& layout, Eigen::Vector3d* angles) {
  if (layout.axes == 1) {
    const double twist = 2 * std::atan2(rotation.vec()[layout.order[0]], rotation.w());
    (*angles)[0] = twist + 2 * std::numbers::pi * std::round(((*angles)[0] - twist) / (2 * std::numbers::pi));
    return;
  }
  // Held at zero, the third angle pulls the choice of branch towards the one in which it is smallest.
  *angles = EulerNear(rotation, layout.order, {(*angles)[0], (*angles)[1], 0});
}

}  // namespace

BvhDocument ExportClip(const MotionClip& clip, const ClipExportOptions& options) {
  const Skeleton& skeleton = clip.skeleton();
  const double metres_per_unit = options.metres_per_unit.value_or(skeleton.metres_per_unit());
  if (!(metres_per_unit > 0)) throw std::invalid_argument("ExportClip: metres per unit must be positive");
  const double scale = 1 / metres_per_unit;
  const bool turned = skeleton.up_axis() == UpAxis::kZ;
  const Eigen::Quaterniond turn = turned ? YUpFromZUp().conjugate() : Eigen::Quaterniond::Identity();
  const int joints = skeleton.joint_count();
  const int root = skeleton.moving_root();

  // The joint that carries the body through the world: the first one in the portable form, in the source's form
  // the moving root or the nearest joint above it that has position channels.
  int carrier = options.source_channels ? root : 0;
  while (options.source_channels && carrier > 0 && !HasPosition(skeleton.joint(carrier).channels)) {
    carrier = skeleton.parent(carrier);
  }

  BvhDocument document;
  document.source = clip.name;
  document.frame_time_s = 1 / clip.frame_rate_hz();
  std::vector<RotationLayout> layouts(joints);
  std::vector<int> position_joints;
  int channels = 0;
  for (int j = 0; j < joints; ++j) {
    const Joint& joint = skeleton.joint(j);
    BvhDocument::Node node;
    node.name = joint.name;
    node.parent = joint.parent;
    node.offset = turn * joint.offset_m * scale;
    if (joint.end_site_m) node.end_site = turn * *joint.end_site_m * scale;
    node.first_channel = channels;
    const std::vector<int> axes = RotationAxes(joint.channels);
    layouts[j].order = CompleteOrder(axes);
    if (options.source_channels) {
      node.channels = joint.channels;
    } else {
      if (j == 0) node.channels = {Channel::kXPosition, Channel::kYPosition, Channel::kZPosition};
      for (const int axis : layouts[j].order) node.channels.push_back(static_cast<Channel>(3 + axis));
    }
    for (size_t c = 0; c < node.channels.size(); ++c) {
      if (!IsPosition(node.channels[c])) layouts[j].rows[layouts[j].axes++] = channels + static_cast<int>(c);
    }
    if (HasPosition(node.channels)) position_joints.push_back(j);
    channels += static_cast<int>(node.channels.size());
    document.nodes.push_back(std::move(node));
  }

  document.values.resize(channels, clip.frame_count());
  for (const int j : position_joints) {
    const BvhDocument::Node& node = document.nodes[j];
    for (int f = 0; f < clip.frame_count(); ++f) {
      const Eigen::Vector3d position =
          j == carrier ? Eigen::Vector3d(turn * clip.root_positions().col(f) * scale) : node.offset;
      for (size_t c = 0; c < node.channels.size(); ++c) {
        if (!IsPosition(node.channels[c])) continue;
        document.values(node.first_channel + static_cast<int>(c), f) = position[Axis(node.channels[c])];
      }
    }
  }
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (int j = 0; j < joints; ++j) {
    const RotationLayout& layout = layouts[j];
    if (layout.axes == 0) continue;
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();
    for (int f = 0; f < clip.frame_count(); ++f) {
      const Eigen::Quaterniond rotation =
          turned ? turn * clip.rotation(f, j) * turn.conjugate() : clip.rotation(f, j);
      if (layout.axes == 3) {
        angles = EulerNear(rotation, layout.order, angles);
      } else {
        WriteReduced(rotation, layout, &angles);
      }
      for (int i = 0; i < layout.axes; ++i) document.values(layout.rows[i], f) = angles[i] * kDegrees;
    }
  }
  return document;
}

}  // namespace morphograph
