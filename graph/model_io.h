#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "graph/motion_graph.h"

namespace morphograph {

/// Newest version of the model file; older ones are read too.
inline constexpr int kModelFormatVersion = 3;
/// Version that a model is written in: the oldest whose readers understand it.
int FormatVersionOf(const MotionGraph& graph);

/// The model file's bytes; the same graph gives the same bytes. Format: see graph/MODEL_FORMAT.md.
std::string SerialiseModel(const MotionGraph& graph);

/// Reads a model. @throws DatasetError when damaged (checksum), truncated, or of a newer version.
std::shared_ptr<const MotionGraph> ParseModel(std::string_view bytes, const std::string& source);
std::shared_ptr<const MotionGraph> LoadModel(const std::filesystem::path& path);

/// Writes atomically.
void SaveModel(const MotionGraph& graph, const std::filesystem::path& path);

}  // namespace morphograph
