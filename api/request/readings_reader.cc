#include "api/request/readings_reader.h"

#include <cmath>
#include <limits>
#include <set>

#include "api/request/control_reader.h"
#include "api/request/object_reader.h"

namespace morphograph {
namespace {

using nlohmann::json;

constexpr std::size_t kMostSensors = 100;
constexpr std::size_t kMostSamples = 200'000;
constexpr double kFarthestOffset_m = 3;

Placement ReadPlacement(const json& value, const std::string& pointer, Findings* findings) {
  Placement placement;
  if (!value.is_object()) {
    findings->Malformed(pointer, "must be an object with a \"joint\"");
    return placement;
  }
  ObjectReader reader(value, pointer, findings);
  placement.joint = reader.Required("joint", reader.Text("joint"), "the joint that the sensor is fixed to").value_or("");
  placement.name = reader.Text("name").value_or(placement.joint);
  if (const auto offset = reader.SpacePoint("offset")) {
    placement.offset_m = *offset;
    if (placement.offset_m.norm() > kFarthestOffset_m) findings->Unmeetable(reader.At("offset"), "at most 3 m from the joint");
  }
  if (const json* orientation = reader.Take("orientation")) {
    Eigen::Vector4d wxyz;
    if (ReadCoordinates(*orientation, reader.At("orientation"), 4, "a unit quaternion, [w, x, y, z]", findings, wxyz.data())) {
      if (std::abs(wxyz.norm() - 1) > 1e-3) {
        findings->Malformed(reader.At("orientation"), "must be a unit quaternion; this one has length " + NumberText(wxyz.norm()));
      } else {
        placement.joint_from_sensor = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized();
      }
    }
  }
  reader.RefuseOthers();
  return placement;
}

void ReadTimes(ObjectReader* reader, std::size_t samples, Readings* readings) {
  const auto rate = reader->Bounded("rate", {1, 2000, "samples a second"});
  const json* times = reader->List("times", 1, kMostSamples, "times");
  if (reader->Has("rate") == reader->Has("times")) {
    reader->findings()->Malformed(reader->At("rate"), "give either \"rate\" or \"times\"");
    return;
  }
  if (rate) {
    for (std::size_t i = 0; i < samples; ++i) readings->times_s.push_back(static_cast<double>(i) / *rate);
    return;
  }
  if (!times) return;
  if (times->size() != samples) {
    reader->findings()->Malformed(reader->At("times"), "must be as many as there are readings, " + std::to_string(samples));
    return;
  }
  for (std::size_t i = 0; i < times->size() && !reader->findings()->full(); ++i) {
    const json& time = (*times)[i];
    const std::string at = reader->At("times") + "/" + std::to_string(i);
    if (!time.is_number()) {
      reader->findings()->Malformed(at, "must be seconds");
    } else if (!readings->times_s.empty() && !(time.get<double>() > readings->times_s.back())) {
      reader->findings()->Malformed(at, "must come after the time before it");
    } else {
      readings->times_s.push_back(time.get<double>());
    }
  }
}

}  // namespace

std::vector<Placement> ReadPlacementList(ObjectReader* reader, Findings* findings) {
  std::vector<Placement> placements;
  std::set<std::string> names;
  const json* list = reader->List("placements", 1, kMostSensors, "placements");
  if (!list && !reader->Has("placements")) findings->Malformed(reader->At("placements"), "required: where the sensors sit");
  for (std::size_t i = 0; list && i < list->size() && !findings->full(); ++i) {
    const std::string at = reader->At("placements") + "/" + std::to_string(i);
    placements.push_back(ReadPlacement((*list)[i], at, findings));
    if (!names.insert(placements.back().name).second) findings->Malformed(at + "/name", "two placements have this name");
  }
  return placements;
}

PlacedReadings ReadPlacedReadings(const json& object, const std::string& pointer, Findings* findings, double* tolerance, double* weight) {
  PlacedReadings placed;
  ObjectReader reader(object, pointer, findings);
  placed.placements = ReadPlacementList(&reader, findings);
  for (const Placement& placement : placed.placements) placed.readings.names.push_back(placement.name);
  const json* rows = reader.List("readings", 1, kMostSamples, "samples");
  if (!rows && !reader.Has("readings")) findings->Malformed(reader.At("readings"), "required: a row a sample, three numbers a sensor");
  ReadTimes(&reader, rows ? rows->size() : 0, &placed.readings);
  if (tolerance) ReadTolerance("tolerance", {0.01, 1000, "m/s^2"}, &reader, tolerance);
  if (weight) ReadWeight(&reader, weight);
  reader.RefuseOthers();
  if (!rows || findings->any()) return placed;
  const std::size_t width = 3 * placed.placements.size();
  placed.readings.values.resize(static_cast<Eigen::Index>(width), static_cast<Eigen::Index>(rows->size()));
  for (std::size_t i = 0; i < rows->size() && !findings->full(); ++i) {
    const json& row = (*rows)[i];
    const std::string at = reader.At("readings") + "/" + std::to_string(i);
    if (!row.is_array() || row.size() != width) {
      findings->Malformed(at, "must be a list of " + std::to_string(width) + " numbers, three a sensor");
      continue;
    }
    for (std::size_t v = 0; v < width; ++v) {
      if (!row[v].is_number() && !row[v].is_null()) findings->Malformed(at + "/" + std::to_string(v), "must be a number, or null where it was lost");
      placed.readings.values(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(i)) =
          row[v].is_number() ? row[v].get<double>() : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return placed;
}

}  // namespace morphograph
