#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "datasets/bvh_document.h"

namespace morphograph {

/// What a reader accepts before it gives up, so that a hostile file stays cheap.
struct BvhLimits {
  int max_joints = 2000;
  int max_depth = 500;
  std::int64_t max_frames = 2'000'000;
  std::int64_t max_values = 400'000'000;  // channels x frames
  // Joints x frames, whether or not the joints have channels: a clip holds a rotation for each, 32 bytes, which a file of a few
  // characters a frame can ask for by the thousand.
  std::int64_t max_joint_frames = 30'000'000;
};

/// Parses BVH text.
///
/// Takes CRLF, tabs, a byte order mark, `Frames :`, exponents, leaves without End Site, any channel set on
/// any joint, any rotation order, and any locale. Joint names come out as UTF-8 (see Utf8FromUnknown). Memory grows with the text, never with what a header claims.
///
/// @param source  name used in messages.
/// @throws DatasetError with line and column.
BvhDocument ParseBvh(std::string_view text, std::string source, const BvhLimits& limits = {});

/// Reads and parses a file. @throws DatasetError also when it cannot be read.
BvhDocument ReadBvhFile(const std::filesystem::path& path, const BvhLimits& limits = {});

}  // namespace morphograph
