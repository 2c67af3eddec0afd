#pragma once

#include <string>
#include <string_view>

#include "datasets/readings.h"

namespace morphograph {

/// Markers of a TRC file (Motion Analysis; OpenSim and OpenCap write it), in metres.
///
/// Five header lines, then a row a frame: number, time, x y z of each marker. Units "m", "cm" and "mm" are known; how many markers there are is what the names
/// say, how many frames what the rows are. A marker whose cells are empty, or all exactly 0 as some writers put it, was not seen: NaN. Axes are the file's own;
/// Y is up in what most writers make.
/// @throws DatasetError with line and column.
Readings ParseTrc(std::string_view text, const std::string& file);

}  // namespace morphograph
