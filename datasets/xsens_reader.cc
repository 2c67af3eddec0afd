#include "datasets/xsens_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>

#include "datasets/errors.h"
#include "datasets/file_text.h"
#include "datasets/internal/table_text.h"
#include "datasets/text_encoding.h"

namespace morphograph {
namespace {

constexpr double kLost = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kCounterPeriod = 65536;
constexpr std::size_t kMostSensors = 500, kHeadLength = 4000;
constexpr double kHighestRate_hz = 10000, kLongest_s = 86400;
constexpr int kValues = 10;  // acceleration 3, rate 3, orientation 4
constexpr std::array<const char*, kValues> kTitles = {"Acc_X",   "Acc_Y",   "Acc_Z",   "Gyr_X",   "Gyr_Y",
                                                      "Gyr_Z",   "Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3"};

struct XsensSensor {
  double rate_hz = 0;
  bool has_rates = false, has_orientations = false;
  std::map<std::int64_t, std::array<double, kValues>> samples;  // by unwrapped packet counter
};

// "// Update Rate: 100.0Hz" and "Acquisition frequency: 100 Hz" both put the number before the unit.
std::optional<double> RateOf(std::string_view line) {
  const std::size_t unit = line.find("Hz");
  if (unit == std::string_view::npos) return std::nullopt;
  std::string_view before = TrimmedText(line.substr(0, unit));
  const std::size_t from = before.find_last_not_of("0123456789.");
  if (from != std::string_view::npos) before.remove_prefix(from + 1);
  double rate = 0;
  const auto [end, error] = std::from_chars(before.data(), before.data() + before.size(), rate);
  if (before.empty() || error != std::errc() || end != before.data() + before.size()) return std::nullopt;
  return rate;
}

class XsensParser {
 public:
  explicit XsensParser(const XsensText& source) : table_(source.text, source.file) {}

  XsensSensor Read() {
    ReadHeader();
    std::string_view line;
    while (table_.NextContent(&line, "//")) ReadRow(CellsOf(line, separator_));
    if (sensor_.samples.empty()) table_.Fail(0, "no sample follows the header");
    return std::move(sensor_);
  }

 private:
  void ReadHeader() {
    std::string_view line;
    do {
      if (!table_.NextContent(&line)) table_.Fail(0, "no line of column names (PacketCounter, Acc_X and so on)");
      if (const std::optional<double> rate = RateOf(line)) {
        sensor_.rate_hz = *rate;
        if (!(*rate > 0 && *rate <= kHighestRate_hz)) table_.Fail(1, "the update rate must be above 0 and at most 10000 Hz");
      }
    } while (line.find("PacketCounter") == std::string_view::npos || line.find("Acc_X") == std::string_view::npos);
    if (sensor_.rate_hz == 0) table_.Fail(0, "no update rate (in Hz) stands above the column names");
    for (const char candidate : {'\t', ';', ','}) {
      if (line.find(candidate) != std::string_view::npos) {
        separator_ = candidate;
        break;
      }
    }
    const std::vector<TableCell> cells = CellsOf(line, separator_);
    width_ = cells.size();
    columns_.fill(-1);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (cells[c].text == "PacketCounter") counter_ = c;
      for (std::size_t v = 0; v < kValues; ++v) {
        if (cells[c].text == kTitles[v]) columns_[v] = static_cast<int>(c);
      }
    }
    const auto has = [&](std::size_t first, std::size_t count) {
      return std::all_of(columns_.begin() + first, columns_.begin() + first + count, [](int column) { return column >= 0; });
    };
    if (!has(0, 3)) table_.Fail(1, "the columns Acc_X, Acc_Y and Acc_Z are needed");
    sensor_.has_rates = has(3, 3);
    sensor_.has_orientations = has(6, 4);
  }

  void ReadRow(const std::vector<TableCell>& cells) {
    if (cells.size() != width_) table_.Fail(1, "expected " + std::to_string(width_) + " cells, found " + std::to_string(cells.size()));
    const double counter = table_.Number(cells[counter_]);
    if (counter != std::floor(counter) || counter < 0 || counter > 1e12) table_.Fail(cells[counter_].column, "the packet counter must be a whole number, 0 or more");
    auto unwrapped = static_cast<std::int64_t>(counter);
    if (last_) {
      // Back by more than half of the period means round once more; by less, a packet that was overtaken.
      const std::int64_t turn = *last_ - (*last_ % kCounterPeriod + kCounterPeriod) % kCounterPeriod;
      if (unwrapped < kCounterPeriod) {
        unwrapped += turn;
        if (*last_ - unwrapped > kCounterPeriod / 2) unwrapped += kCounterPeriod;
        if (unwrapped - *last_ > kCounterPeriod / 2) unwrapped -= kCounterPeriod;
      }
      if (unwrapped - sensor_.samples.begin()->first > kLongest_s * sensor_.rate_hz) {
        table_.Fail(cells[counter_].column, "the packet counter runs over more than a day");
      }
    }
    last_ = unwrapped;
    std::array<double, kValues>& values = sensor_.samples[unwrapped];
    for (std::size_t v = 0; v < kValues; ++v) values[v] = columns_[v] < 0 ? kLost : table_.NumberOrLost(cells[static_cast<std::size_t>(columns_[v])]);
  }

  TableText table_;
  XsensSensor sensor_;
  char separator_ = ',';
  std::size_t width_ = 0, counter_ = 0;
  std::array<int, kValues> columns_;
  std::optional<std::int64_t> last_;
};

// The part of a name behind its last '_' when it is a serial number: 8 hexadecimal digits, a number among them.
std::string WithoutSerialNumber(const std::string& stem) {
  const std::size_t at = stem.rfind('_');
  if (at == std::string::npos || at == 0 || stem.size() - at != 9) return stem;
  const std::string_view serial = std::string_view(stem).substr(at + 1);
  const bool hexadecimal = serial.find_first_not_of("0123456789ABCDEFabcdef") == std::string_view::npos;
  return hexadecimal && serial.find_first_of("0123456789") != std::string_view::npos ? stem.substr(0, at) : stem;
}

// How much of the beginning of all names is to go: up to a '_', leaving the side of the body when all sensors are on one.
std::size_t SharedLength(const std::vector<std::string>& names) {
  std::size_t shared = names.front().size();
  for (const std::string& name : names) {
    std::size_t same = 0;
    while (same < std::min(shared, name.size()) && name[same] == names.front()[same]) ++same;
    shared = same;
  }
  const auto cut = [&](std::size_t length) {
    const std::size_t at = length == 0 ? std::string::npos : names.front().rfind('_', length - 1);
    return at == std::string::npos ? 0 : at + 1;
  };
  shared = cut(shared);
  const std::size_t before = shared < 2 ? 0 : cut(shared - 1);
  const std::string word = shared > before ? names.front().substr(before, shared - before - 1) : "";
  for (const char* side : {"L", "R", "l", "r", "Left", "Right", "left", "right"}) {
    if (word == side) return before;
  }
  return shared;
}

}  // namespace

bool IsXsensText(std::string_view text) {
  const std::string_view head = text.substr(0, kHeadLength);
  return head.find("PacketCounter") != std::string_view::npos && head.find("Acc_X") != std::string_view::npos;
}

std::vector<std::string> XsensNames(const std::vector<std::string>& stems) {
  std::vector<std::string> names;
  for (const std::string& stem : stems) names.push_back(WithoutSerialNumber(stem));
  if (names.size() < 2) return names;
  const std::size_t shared = SharedLength(names);
  for (std::string& name : names) name.erase(0, shared);
  std::vector<std::string> sorted = names;
  std::sort(sorted.begin(), sorted.end());
  const bool clear = std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end() && !sorted.front().empty();
  return clear ? names : stems;
}

SensorRecording ParseXsens(const std::vector<XsensText>& sources) {
  if (sources.empty() || sources.size() > kMostSensors) throw DatasetError("Xsens", "1 to 500 sensors are needed");
  std::vector<XsensSensor> sensors;
  std::map<std::int64_t, Eigen::Index> columns;  // of every counter that any sensor has
  for (const XsensText& source : sources) {
    sensors.push_back(XsensParser(source).Read());
    const XsensSensor &sensor = sensors.back(), &first = sensors.front();
    if (std::abs(sensor.rate_hz - first.rate_hz) > 1e-6 * first.rate_hz) {
      throw DatasetError(source.file, "its update rate differs from that of " + sources.front().file);
    }
    if (sensor.samples.rbegin()->first < first.samples.begin()->first || sensor.samples.begin()->first > first.samples.rbegin()->first) {
      throw DatasetError(source.file, "its packet counters do not meet those of " + sources.front().file + ": not recorded together?");
    }
    for (const auto& [counter, values] : sensor.samples) columns.try_emplace(counter, 0);
  }
  Eigen::Index samples = 0;
  SensorRecording recording;
  for (auto& [counter, column] : columns) {
    column = samples++;
    recording.accelerations.times_s.push_back(static_cast<double>(counter - columns.begin()->first) / sensors.front().rate_hz);
  }
  const auto count = static_cast<Eigen::Index>(sources.size());
  const auto any = [&](bool XsensSensor::*has) { return std::any_of(sensors.begin(), sensors.end(), [&](const XsensSensor& s) { return s.*has; }); };
  recording.accelerations.values.setConstant(3 * count, samples, kLost);
  recording.rates_rad_s.setConstant(any(&XsensSensor::has_rates) ? 3 * count : 0, samples, kLost);
  recording.orientations.setConstant(any(&XsensSensor::has_orientations) ? 4 * count : 0, samples, kLost);
  for (Eigen::Index s = 0; s < count; ++s) {
    recording.accelerations.names.push_back(Utf8FromUnknown(sources[static_cast<std::size_t>(s)].name));
    for (const auto& [counter, values] : sensors[static_cast<std::size_t>(s)].samples) {
      const Eigen::Index column = columns.at(counter);
      const Eigen::Map<const Eigen::Matrix<double, kValues, 1>> sample(values.data());
      recording.accelerations.values.col(column).segment<3>(3 * s) = sample.head<3>();
      if (recording.rates_rad_s.rows() > 0) recording.rates_rad_s.col(column).segment<3>(3 * s) = sample.segment<3>(3);
      if (recording.orientations.rows() > 0) recording.orientations.col(column).segment<4>(4 * s) = sample.tail<4>().normalized();
    }
  }
  return recording;
}

SensorRecording ReadXsens(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::vector<fs::path> files;
  std::error_code error;
  if (fs::is_regular_file(path, error)) {
    files.push_back(path);
  } else {
    const bool folder = fs::is_directory(path, error);
    const fs::path parent = folder ? path : path.has_parent_path() ? path.parent_path() : fs::path(".");
    const std::string beginning = folder ? "" : path.filename().string();
    for (const auto& entry : fs::directory_iterator(parent, error)) {
      const std::string ending = entry.path().extension().string();
      if (!entry.is_regular_file(error) || !entry.path().filename().string().starts_with(beginning)) continue;
      if (ending == ".txt" || ending == ".TXT" || ending == ".csv") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());  // folders are listed in any order
  }
  std::vector<XsensText> sources;
  std::vector<std::string> stems;
  for (const fs::path& file : files) {
    if (sources.size() == kMostSensors) throw DatasetError(path.string(), "more than 500 sensors");
    std::string text = ReadFileText(file);
    if (!IsXsensText(text)) continue;
    sources.push_back({"", file.string(), std::move(text)});
    stems.push_back(file.stem().string());
  }
  if (sources.empty()) throw DatasetError(path.string(), fs::exists(path, error) ? "no Xsens text file here" : "does not exist");
  const std::vector<std::string> names = XsensNames(stems);
  for (std::size_t i = 0; i < sources.size(); ++i) sources[i].name = names[i];
  return ParseXsens(sources);
}

}  // namespace morphograph
