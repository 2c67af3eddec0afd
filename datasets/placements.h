#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/skeleton.h"

namespace morphograph {

/// Where a sensor or a marker is fixed to the body.
struct Placement {
  std::string name;   // of its columns in a file of readings
  std::string joint;  // a role ("left_wrist") or the skeleton's own joint name
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();                       // from the joint, in the joint's frame
  Eigen::Quaterniond joint_from_sensor = Eigen::Quaterniond::Identity();  // how a sensor's axes lie in that frame
};

/// Reads placements: a JSON array of objects, or an object whose member "placements" is one. Each has "joint" and may have "name" (the
/// joint when absent), "offset" [x, y, z] in metres and "orientation", a unit quaternion [w, x, y, z].
/// @throws DatasetError naming the file and the JSON pointer; two placements may not have one name.
std::vector<Placement> ParsePlacements(std::string_view json, const std::string& file);
std::vector<Placement> ReadPlacements(const std::filesystem::path& path);
/// The same as text that ParsePlacements() reads.
std::string PlacementsJson(const std::vector<Placement>& placements);

/// Placements at joints, without offset: one a name. Which columns a file has then says all.
std::vector<Placement> PlacementsAtJoints(const std::vector<std::string>& joints);

/// The joint of each placement. @throws std::invalid_argument naming a joint that the skeleton does not have, or lies above its moving root.
std::vector<int> JointsOf(const std::vector<Placement>& placements, const Skeleton& skeleton);

}  // namespace morphograph
