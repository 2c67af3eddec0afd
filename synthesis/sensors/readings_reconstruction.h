#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "datasets/stream_repair.h"
#include "synthesis/sensors/reconstruction.h"
#include "synthesis/sensors/standing_alignment.h"

namespace morphograph {

/// Readings as they come, damage included, and what is known of their sensors.
struct ReconstructionRequest {
  ReconstructionMethod method = ReconstructionMethod::kGraph;
  Readings readings;
  std::vector<Placement> placements;   // by name; sensors without one sit at the joint that they are called after
  std::optional<AlignmentRequest> alignment = std::nullopt;  // empty: sensors sit as they are told to; times are those of the readings
  double low_pass_hz = 0;              // of the readings, before anything is made of them; 0: none
  std::string source = "readings";     // the file, for messages
};

/// The reconstruction and what was wrong with the readings.
struct ReconstructedReadings {
  Reconstruction reconstruction;
  RepairedReadings repaired;
  std::vector<std::string> sensors;    // that were used
  std::optional<SensorTurns> alignment;  // of these, where it was asked for; times are those of the readings
};

inline constexpr int kAlignmentRounds = 2;

/// Gives the reconstructor for sensors at some places; one that was made before may do.
using ReconstructorSource = std::function<std::shared_ptr<const Reconstructor>(const std::vector<Placement>&)>;

/// Repairs readings, leaves dead sensors out, aligns the others where that is asked for, and reconstructs. Of more than 12 markers the 12 principal ones are used (PrincipalMarkers()), which is told.
///
/// Alignment: gravity in a standing phase gives the tilt of every sensor (AlignByStanding); then the motion is reconstructed, every sensor turned about the vertical and shifted in time so that it agrees
/// with it (AlignByMotion), kAlignmentRounds times, before the motion that is returned. It so takes as many times as long.
/// @throws DatasetError for readings that nothing can be made of, or that look like markers where accelerations are wanted or the other way round; UnsatisfiableRequest for sensors that cannot be placed or a stream shorter than a step,
///   markers that are to be aligned ("/alignment"), and readings without a standing phase or with one that is none ("/alignment/standing").
ReconstructedReadings ReconstructReadings(const MotionGraph& graph, const ReconstructionRequest& request, const ReconstructorSource& make);

}  // namespace morphograph
