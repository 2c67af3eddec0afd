#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/readings.h"

namespace morphograph {

enum class ReadingsKind { kAccelerations, kMarkers };

/// Readings of some file, whatever its format.
struct RecordedReadings {
  Readings readings;  // m/s^2 with gravity, or metres with Y up
  std::optional<ReadingsKind> kind;  // empty: the file does not say (our own CSV)
  std::string format;                // in words, for reports
  std::vector<std::string> notes;    // what was assumed or turned, one sentence each
};

/// Reads sensors or markers, recognising the format by the content: our own CSV (readings.h), TRC, raw Xsens text (a file, a folder, or the beginning of several files'
/// names), CSV of foot sensors, tables of markers. Marker files whose body lies along Z are turned upright, and the notes say so.
/// @throws DatasetError naming the file, line and column.
RecordedReadings ReadReadings(const std::filesystem::path& path);

/// The same for a text that came by another way than a file.
/// @param name  used in messages, and as the sensor's name for a single Xsens text.
RecordedReadings ParseReadings(std::string_view text, const std::string& name);

}  // namespace morphograph
