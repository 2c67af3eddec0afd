#include "datasets/readings_reader.h"

#include "datasets/errors.h"
#include "datasets/file_text.h"
#include "datasets/foot_sensor_reader.h"
#include "datasets/marker_csv_reader.h"
#include "datasets/marker_units.h"
#include "datasets/trc_reader.h"
#include "datasets/xsens_reader.h"

namespace morphograph {
namespace {

std::string_view WithoutMark(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

RecordedReadings Recorded(Readings readings, std::optional<ReadingsKind> kind, const char* format) {
  RecordedReadings recorded;
  recorded.readings = std::move(readings);
  recorded.kind = kind;
  recorded.format = format;
  return recorded;
}

RecordedReadings FromXsens(SensorRecording recording) {
  return Recorded(std::move(recording.accelerations), ReadingsKind::kAccelerations, "Xsens text");
}

RecordedReadings UprightMarkers(const Readings& markers, const char* format, UpAxis usual) {
  const double unit = MetresPerMarkerUnit(markers);
  const UpAxis up = UpAxisOfMarkers(markers, usual);
  RecordedReadings recorded = Recorded(MarkersInMetres(markers, unit, up), ReadingsKind::kMarkers, format);
  if (unit == 0.01) recorded.notes.emplace_back("the markers are taken to be in centimetres");
  if (unit == 0.001) recorded.notes.emplace_back("the markers are taken to be in millimetres");
  if (up == UpAxis::kZ) recorded.notes.emplace_back("the markers' Z axis points up; it was turned to Y");
  return recorded;
}

}  // namespace

RecordedReadings ParseReadings(std::string_view text, const std::string& name) {
  const std::string_view content = WithoutMark(text);
  if (content.starts_with("PathFileType")) return UprightMarkers(ParseTrc(text, name), "TRC markers", UpAxis::kY);
  if (content.starts_with("HIERARCHY")) throw DatasetError(name, 1, 1, "is a BVH clip; readings of sensors or markers are needed");
  if (IsXsensText(content)) {
    const std::string stem = std::filesystem::path(name).stem().string();
    return FromXsens(ParseXsens({{XsensNames({stem.empty() ? "sensor" : stem}).front(), name, std::string(text)}}));
  }
  if (IsFootSensorText(content)) {
    RecordedReadings recorded = Recorded(ParseFootSensors(text, name).accelerations, ReadingsKind::kAccelerations, "foot sensors");
    recorded.notes.emplace_back("the file does not say its rate; 204.8 Hz was taken");
    return recorded;
  }
  if (IsMarkerTable(content)) {
    // Capture studios have Z up; a table of feet alone does not show it.
    RecordedReadings recorded = UprightMarkers(ParseMarkerTable(text, name), "table of markers", UpAxis::kZ);
    recorded.notes.emplace_back("the file does not say its rate; 100 Hz was taken");
    return recorded;
  }
  return Recorded(ParseReadingsCsv(text, name), std::nullopt, "CSV");
}

RecordedReadings ReadReadings(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return FromXsens(ReadXsens(path));
  if (!std::filesystem::exists(path, error) && path.has_filename()) {
    // Perhaps the beginning of several files' names. When there are none, opening it says best what is wrong.
    const std::filesystem::path parent = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    for (const auto& entry : std::filesystem::directory_iterator(parent, error)) {
      if (entry.path().filename().string().starts_with(path.filename().string())) return FromXsens(ReadXsens(path));
    }
  }
  return ParseReadings(ReadFileText(path), path.string());
}

}  // namespace morphograph
