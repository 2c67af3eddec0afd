#include "api/request/object_reader.h"

#include <algorithm>
#include <cmath>

#include "synthesis/synthesis_types.h"

namespace morphograph {

using nlohmann::json;

const json* ObjectReader::Take(std::string_view name) {
  known_.push_back(name);
  const auto found = object_.find(name);
  return found == object_.end() ? nullptr : &*found;
}

std::optional<double> ObjectReader::Finite(std::string_view name) {
  const json* value = Take(name);
  if (!value) return std::nullopt;
  if (!value->is_number()) {
    findings_->Malformed(At(name), std::string("must be a number, not ") + value->type_name());
    return std::nullopt;
  }
  return value->get<double>();
}

std::optional<double> ObjectReader::Bounded(std::string_view name, const NumberBounds& bounds) {
  const json* value = Take(name);
  return value ? ReadBounded(*value, At(name), bounds, findings_) : std::nullopt;
}

std::optional<int> ObjectReader::Whole(std::string_view name, int least, int most) {
  const json* value = Take(name);
  if (!value) return std::nullopt;
  if (!value->is_number_integer()) {
    findings_->Malformed(At(name), "must be an integer");
    return std::nullopt;
  }
  // As text where an int cannot hold it: -1e18 is an integer too.
  const bool is_low = !value->is_number_unsigned() && value->get<std::int64_t>() < least;
  if (is_low || (value->is_number_unsigned() && least > 0 && value->get<std::uint64_t>() < static_cast<std::uint64_t>(least))) {
    findings_->Malformed(At(name), "must be at least " + std::to_string(least));
    return std::nullopt;
  }
  const auto number = value->get<std::uint64_t>();
  if (value->is_number_unsigned() && number > static_cast<std::uint64_t>(most)) {
    findings_->Unmeetable(At(name), "at most " + std::to_string(most));
    return std::nullopt;
  }
  return value->get<int>();
}

std::optional<std::string> ObjectReader::Text(std::string_view name) {
  const json* value = Take(name);
  if (!value) return std::nullopt;
  if (!value->is_string()) {
    findings_->Malformed(At(name), std::string("must be a string, not ") + value->type_name());
    return std::nullopt;
  }
  const auto& text = value->get_ref<const std::string&>();
  if (text.empty() || text.size() > 200) {
    findings_->Malformed(At(name), "must have 1 to 200 bytes");
    return std::nullopt;
  }
  return text;
}

std::optional<Eigen::Vector2d> ObjectReader::FloorPoint(std::string_view name) {
  Eigen::Vector2d point;
  const json* value = Take(name);
  if (!value || !ReadCoordinates(*value, At(name), 2, "two numbers, [x, z] in metres", findings_, point.data())) return std::nullopt;
  return point;
}

std::optional<Eigen::Vector3d> ObjectReader::SpacePoint(std::string_view name) {
  Eigen::Vector3d point;
  const json* value = Take(name);
  if (!value || !ReadCoordinates(*value, At(name), 3, "three numbers, [x, y, z] in metres", findings_, point.data())) return std::nullopt;
  return point;
}

const json* ObjectReader::Object(std::string_view name) {
  const json* value = Take(name);
  if (value && !value->is_object()) {
    findings_->Malformed(At(name), std::string("must be an object, not ") + value->type_name());
    return nullptr;
  }
  return value;
}

const json* ObjectReader::List(std::string_view name, std::size_t least, std::size_t most, std::string_view of_what) {
  const json* value = Take(name);
  if (!value) return nullptr;
  if (!value->is_array()) {
    findings_->Malformed(At(name), "must be a list of " + std::string(of_what) + ", not " + value->type_name());
    return nullptr;
  }
  if (value->size() < least) {
    findings_->Malformed(At(name), "must have at least " + std::to_string(least) + " " + std::string(of_what));
    return nullptr;
  }
  if (value->size() > most) {
    findings_->Unmeetable(At(name), "at most " + std::to_string(most) + " " + std::string(of_what));
    return nullptr;
  }
  return value;
}

void ObjectReader::ReportMissing(std::string_view name, std::string_view what) const {
  findings_->Malformed(At(name), std::string("required: ").append(what));
}

void ObjectReader::RefuseOthers(const std::vector<std::string_view>& future) {
  for (const auto& item : object_.items()) {
    if (findings_->full()) return;
    if (std::find(known_.begin(), known_.end(), item.key()) != known_.end()) continue;
    const bool is_future = std::find(future.begin(), future.end(), item.key()) != future.end();
    findings_->Malformed(At(item.key()), is_future ? "this field does not exist yet in this version" : "unknown field");
  }
}

bool ReadCoordinates(const json& value, const std::string& pointer, int count, std::string_view form, Findings* findings, double* out) {
  bool fits = value.is_array() && value.size() == static_cast<std::size_t>(count);
  for (int i = 0; fits && i < count; ++i) fits = value[static_cast<std::size_t>(i)].is_number();
  if (!fits) {
    findings->Malformed(pointer, "must be " + std::string(form));
    return false;
  }
  for (int i = 0; i < count; ++i) {
    out[i] = value[static_cast<std::size_t>(i)].get<double>();
    if (std::abs(out[i]) > kMaxStartDistance_m) {
      findings->Unmeetable(pointer, "at most " + NumberText(kMaxStartDistance_m) + " m from the origin");
      return false;
    }
  }
  return true;
}

std::optional<double> ReadBounded(const json& value, const std::string& pointer, const NumberBounds& bounds, Findings* findings) {
  if (!value.is_number()) {
    findings->Malformed(pointer, std::string("must be a number, not ") + value.type_name());
    return std::nullopt;
  }
  const double number = value.get<double>();
  if (number < bounds.least) {
    findings->Unmeetable(pointer, "at least " + NumberText(bounds.least) + " " + bounds.unit);
    return std::nullopt;
  }
  if (number > bounds.most) {
    findings->Unmeetable(pointer, "at most " + NumberText(bounds.most) + " " + bounds.unit);
    return std::nullopt;
  }
  return number;
}

}  // namespace morphograph
