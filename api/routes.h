#pragma once

#include <vector>

#include "api/router.h"
#include "api/service.h"

namespace morphograph {

/// Body limits, bytes.
inline constexpr std::size_t kMaxClipRequestBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxEvaluationBytes = std::size_t{64} << 20;
inline constexpr std::size_t kMaxReadingsBytes = std::size_t{32} << 20;
inline constexpr std::size_t kMaxTrainingBytes = std::size_t{256} << 20;

/// Every route of HTTP version 1 (CONTRACT.md).
std::vector<Route> AllRoutes(Service* service);

// The parts, a file each.
std::vector<Route> ClipRoutes(Service* service);
std::vector<Route> VariantRoutes(Service* service);
std::vector<Route> EvaluationRoutes(Service* service);
std::vector<Route> ModelRoutes(Service* service);
std::vector<Route> JobRoutes(Service* service);
std::vector<Route> SystemRoutes(Service* service);
std::vector<Route> ReconstructionRoutes(Service* service);
std::vector<Route> ViewerRoutes();

}  // namespace morphograph
