#pragma once

#include <string>
#include <string_view>

#include "datasets/readings.h"

namespace morphograph {

/// Rate of marker tables whose files do not say it.
inline constexpr double kMarkerTableRate_hz = 100;

/// Tables of markers as capture studios export them: a frame's number, then x y z of each marker, with one header row (`frame,LASI_x,LASI_y,LASI_z,…`) or two (names,
/// then axes: `,LASI,LASI,LASI,…` and `,x,y,z,…`). Numbers are kept as they are: neither unit nor axes are said (see marker_units.h). Time is the frame's number over the rate.
/// @throws DatasetError with line and column.
Readings ParseMarkerTable(std::string_view text, const std::string& file, double rate_hz = kMarkerTableRate_hz);

/// Whether text looks like such a file.
bool IsMarkerTable(std::string_view text);

}  // namespace morphograph
