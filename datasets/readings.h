#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace morphograph {

/// What sensors or markers said, sample by sample: accelerations (m/s^2, gravity included, in each sensor's axes), or positions of markers (m,
/// Y up). A value that is lost is NaN.
struct Readings {
  std::vector<std::string> names;   // of the sensors
  std::vector<double> times_s;      // rising; steps may differ
  Eigen::MatrixXd values;           // (3 * names x times): x, y, z of the first sensor, then of the second, …

  int sensor_count() const { return static_cast<int>(names.size()); }
  int sample_count() const { return static_cast<int>(times_s.size()); }
  /// Samples a second, by the median step of the times. 0 with fewer than two.
  double rate_hz() const;
};

/// Reads CONTRACT.md's readings.csv and markers.csv: header `time,<sensor>.x,<sensor>.y,<sensor>.z,…`, then a row a sample. A cell that is
/// empty or "nan" is a lost value; blank lines and lines that begin with '#' are passed over.
///
/// Samples need not be in order of time (packets overtake each other): they are sorted. Of several with one time the last counts.
/// @throws DatasetError with line and column for a wrong header, a wrong number of cells, a cell that is no number, a time that is missing.
Readings ParseReadingsCsv(std::string_view text, const std::string& file);

/// The same as text; lost values are empty cells. Times with 6 decimals, values with 9 significant digits.
std::string ReadingsCsv(const Readings& readings);

}  // namespace morphograph
