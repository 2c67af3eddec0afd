#include "datasets/placements.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "datasets/errors.h"
#include "datasets/file_text.h"

namespace morphograph {
namespace {

using nlohmann::json;

// A body is smaller than this, and so is what is worn on it.
constexpr double kFarthest_m = 3;
constexpr std::size_t kMostPlacements = 500;
constexpr int kDeepest = 8;

class PlacementReader {
 public:
  explicit PlacementReader(const std::string& file) : file_(file) {}

  [[noreturn]] void Fail(const std::string& pointer, const std::string& reason) const {
    throw DatasetError(file_, (pointer.empty() ? "the whole document" : pointer) + ": " + reason);
  }

  Placement Read(const json& value, const std::string& at) const {
    if (!value.is_object()) Fail(at, "expected an object with a \"joint\"");
    Placement placement;
    for (const auto& [member, content] : value.items()) {
      const std::string here = at + "/" + member;
      if (member == "joint") {
        placement.joint = Text(content, here);
      } else if (member == "name") {
        placement.name = Text(content, here);
      } else if (member == "offset") {
        const std::vector<double> offset = Numbers(content, here, 3, "[x, y, z] in metres");
        placement.offset_m = Eigen::Vector3d(offset.data());
        if (placement.offset_m.norm() > kFarthest_m) Fail(here, "lies more than 3 m from the joint");
      } else if (member == "orientation") {
        const std::vector<double> q = Numbers(content, here, 4, "a unit quaternion, [w, x, y, z]");
        placement.joint_from_sensor = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
        if (std::abs(placement.joint_from_sensor.norm() - 1) > 1e-3) Fail(here, "must be a unit quaternion");
        placement.joint_from_sensor.normalize();
      } else {
        Fail(here, "unknown field");
      }
    }
    if (placement.joint.empty()) Fail(at, "\"joint\" is missing");
    if (placement.name.empty()) placement.name = placement.joint;
    if (placement.name.find_first_of(",\"\r\n") != std::string::npos) Fail(at + "/name", "must hold no comma, quote or line break");
    return placement;
  }

 private:
  std::string Text(const json& value, const std::string& at) const {
    if (!value.is_string() || value.get_ref<const std::string&>().empty()) Fail(at, "expected a text that is not empty");
    return value.get<std::string>();
  }

  std::vector<double> Numbers(const json& value, const std::string& at, std::size_t count, const char* form) const {
    if (!value.is_array() || value.size() != count) Fail(at, std::string("expected ") + form);
    std::vector<double> numbers;
    for (const json& entry : value) {
      if (!entry.is_number() || !std::isfinite(entry.get<double>())) Fail(at, std::string("expected ") + form);
      numbers.push_back(entry.get<double>());
    }
    return numbers;
  }

  const std::string& file_;
};

}  // namespace

std::vector<Placement> ParsePlacements(std::string_view text, const std::string& file) {
  const PlacementReader reader(file);
  json document;
  try {
    document = json::parse(text, [&](int depth, json::parse_event_t, json&) {
      if (depth > kDeepest) throw DatasetError(file, "nested too deep");
      return true;
    });
  } catch (const json::exception& error) {
    throw DatasetError(file, std::string("not valid JSON: ") + error.what());
  }
  std::string at;
  const json* list = &document;
  if (document.is_object()) {
    for (const auto& [member, content] : document.items()) {
      if (member != "placements") reader.Fail("/" + member, "unknown field");
    }
    if (!document.contains("placements")) reader.Fail("", "\"placements\" is missing");
    list = &document["placements"];
    at = "/placements";
  }
  if (!list->is_array() || list->empty()) reader.Fail(at, "expected a list of placements that is not empty");
  if (list->size() > kMostPlacements) reader.Fail(at, "more than 500 placements");
  std::vector<Placement> placements;
  std::set<std::string> names;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string here = at + "/" + std::to_string(i);
    placements.push_back(reader.Read((*list)[i], here));
    if (!names.insert(placements.back().name).second) {
      reader.Fail(here, "a second placement is called '" + placements.back().name + "'; give it a \"name\"");
    }
  }
  return placements;
}

std::vector<Placement> ReadPlacements(const std::filesystem::path& path) { return ParsePlacements(ReadFileText(path), path.string()); }

std::string PlacementsJson(const std::vector<Placement>& placements) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Placement& placement : placements) {
    const Eigen::Quaterniond& q = placement.joint_from_sensor;
    list.push_back({{"name", placement.name},
                    {"joint", placement.joint},
                    {"offset", {placement.offset_m.x(), placement.offset_m.y(), placement.offset_m.z()}},
                    {"orientation", {q.w(), q.x(), q.y(), q.z()}}});
  }
  return nlohmann::ordered_json({{"placements", list}}).dump(2) + "\n";
}

std::vector<Placement> PlacementsAtJoints(const std::vector<std::string>& joints) {
  std::vector<Placement> placements;
  for (const std::string& joint : joints) placements.push_back({joint, joint});
  return placements;
}

std::vector<int> JointsOf(const std::vector<Placement>& placements, const Skeleton& skeleton) {
  std::vector<int> joints;
  for (const Placement& placement : placements) {
    const int joint = skeleton.FindRoleOrName(placement.joint);
    if (joint < 0) throw std::invalid_argument("the skeleton has no joint '" + placement.joint + "'");
    if (!skeleton.IsBody(joint)) throw std::invalid_argument("joint '" + placement.joint + "' does not move with the body");
    joints.push_back(joint);
  }
  return joints;
}

}  // namespace morphograph
