#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/live_repair.h"
#include "synthesis/sensors/reconstruction.h"

namespace morphograph {

/// A reconstruction that goes on while readings come in: lines of JSON in, lines of JSON out.
///
/// In: `{"time": 0.02, "readings": [ax, ay, az, …]}`, three numbers a sensor, null where lost. Out, one line a frame at kReconstructionRate_hz:
/// `{"time": 0.0333, "root": [x, y, z], "rotations": {"Hips": [w, x, y, z], …}}`: the moving root's place (m, from the origin, facing +Z at first) and every joint's
/// rotation from its parent, the moving root's in the world. A line has "notes" where something was found since the line before: units, gaps, sensors that die or live
/// again; the last line has what was replaced, passed over or clipped. In place of a dead accelerometer the method is told what such a one reads on the average in its recordings.
class ReconstructionStream {
 public:
  /// @throws UnsatisfiableRequest ("/method") for kGraph, which needs all readings at once.
  explicit ReconstructionStream(std::shared_ptr<const Reconstructor> reconstructor);

  /// Lines that are now due, each with its end of line; empty while the stream settles (LiveRepair). Blank lines are passed over.
  /// @throws ProblemError (400) naming what is wrong with the line.
  std::string Push(std::string_view line);
  /// What is still due at the end. @throws ProblemError (400) where nothing can be made of what came.
  std::string Finish();

 private:
  std::string Lines(const std::vector<Eigen::VectorXd>& samples, bool last);

  std::shared_ptr<const Reconstructor> reconstructor_;
  std::unique_ptr<PoseEstimator> estimator_;
  LiveRepair repair_;
  PoseAssembler assembler_;
  Eigen::VectorXd usual_;  // readings, mean over the recordings; empty for markers
  std::size_t told_ = 0;   // notes
  std::int64_t frames_ = 0;
};

}  // namespace morphograph
