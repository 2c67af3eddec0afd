#pragma once

#include "datasets/readings.h"
#include "datasets/skeleton.h"

namespace morphograph {

/// Metres a unit of marker positions, by how far apart the markers of a body lie (median over frames of the largest extent): 1, 0.01 or 0.001. 1 where
/// fewer than two markers are seen at once, or they are as large as no body in any of the three.
double MetresPerMarkerUnit(const Readings& markers);

/// Which axis is up, for markers over a whole body: it is the one along which they spread most, frame by frame (a body is taller than a step is long).
/// @param usual  what it is where no axis stands out by a quarter.
UpAxis UpAxisOfMarkers(const Readings& markers, UpAxis usual);

/// Markers in metres, Y up: scaled, and (x, y, z) with Z up becomes (x, z, -y).
Readings MarkersInMetres(const Readings& markers, double metres_per_unit, UpAxis up);

}  // namespace morphograph
