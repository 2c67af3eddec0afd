#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "graph/motion_graph.h"

namespace morphograph {

/// Version of the model file that is written; older ones are read too.
inline constexpr int kModelFormatVersion = 2;

/// The model file's bytes; the same graph gives the same bytes. Format: see graph/MODEL_FORMAT.md.
std::string SerialiseModel(const MotionGraph& graph);

/// Reads a model. @throws DatasetError when damaged (checksum), truncated, or of a newer version.
std::shared_ptr<const MotionGraph> ParseModel(std::string_view bytes, const std::string& source);
std::shared_ptr<const MotionGraph> LoadModel(const std::filesystem::path& path);

/// Writes atomically.
void SaveModel(const MotionGraph& graph, const std::filesystem::path& path);

}  // namespace morphograph
