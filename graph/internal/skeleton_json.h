#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "datasets/skeleton.h"

namespace morphograph::internal {

/// A skeleton as the model file keeps it: joints with parent, offset, End Site, channels; roles; unit; up axis.
nlohmann::json SkeletonToJson(const Skeleton& skeleton);

/// @throws std::invalid_argument or nlohmann's exceptions when it is not one.
std::shared_ptr<const Skeleton> SkeletonFromJson(const nlohmann::json& json);

}  // namespace morphograph::internal
