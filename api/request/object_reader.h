#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/request/findings.h"

namespace morphograph {

/// Bounds of a number in a request. Past them it is well formed, but nothing can be made of it.
struct NumberBounds {
  double least;
  double most;
  const char* unit;  // for the message: "m"
};

/// Reads the members of one JSON object by name and type. What does not fit goes to the findings, with its pointer, and reads as absent;
/// what was never asked for is refused by RefuseOthers().
class ObjectReader {
 public:
  /// @param object, findings  must outlive the reader.
  ObjectReader(const nlohmann::json& object, std::string pointer, Findings* findings)
      : object_(object), pointer_(std::move(pointer)), findings_(findings) {}

  /// The member, or null when it is absent.
  const nlohmann::json* Take(std::string_view name);
  bool Has(std::string_view name) const { return object_.contains(name); }
  const std::string& pointer() const { return pointer_; }
  std::string At(std::string_view name) const { return PointerTo(pointer_, name); }
  Findings* findings() const { return findings_; }

  /// A finite number; none is infinite, since the parser refuses what is past a double's range.
  std::optional<double> Finite(std::string_view name);
  /// A finite number between bounds (422 outside of them).
  std::optional<double> Bounded(std::string_view name, const NumberBounds& bounds);
  /// An integer from `least` (400 below) to `most` (422 above).
  std::optional<int> Whole(std::string_view name, int least, int most);
  /// 1 to 200 bytes.
  std::optional<std::string> Text(std::string_view name);
  /// [x, z] on the floor, within kMaxStartDistance_m of the origin.
  std::optional<Eigen::Vector2d> FloorPoint(std::string_view name);
  /// [x, y, z], bounded likewise.
  std::optional<Eigen::Vector3d> SpacePoint(std::string_view name);
  /// A nested object; null when it is absent or something else.
  const nlohmann::json* Object(std::string_view name);
  /// A list of `least` (400 below) to `most` (422 above) values; null when it is absent or otherwise.
  const nlohmann::json* List(std::string_view name, std::size_t least, std::size_t most, std::string_view of_what);

  /// Reports a member that must be there and is not.
  template <typename T>
  T Required(std::string_view name, T value, std::string_view what) const {
    if (!value && !Has(name)) ReportMissing(name, what);
    return value;
  }

  /// Whatever was not taken is an error; one of `future` does not exist yet.
  void RefuseOthers(const std::vector<std::string_view>& future = {});

 private:
  void ReportMissing(std::string_view name, std::string_view what) const;

  const nlohmann::json& object_;
  std::string pointer_;
  Findings* findings_;
  std::vector<std::string_view> known_;
};

/// Reads `count` numbers of an array, each no further from 0 than coordinates may be; false, and a finding at `pointer`, when it is
/// something else. `form` describes it: "two numbers, [x, z] in metres".
bool ReadCoordinates(const nlohmann::json& value, const std::string& pointer, int count, std::string_view form, Findings* findings,
                     double* out);

/// A bounded number that stands in a list; findings as Bounded().
std::optional<double> ReadBounded(const nlohmann::json& value, const std::string& pointer, const NumberBounds& bounds, Findings* findings);

}  // namespace morphograph
