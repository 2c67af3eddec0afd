// All markers, and the pose, from a few (Liu 2006): errors beside the nearest neighbour's, and times.
//
//   marker_benchmark --data RECORDINGS [--tune] [--known-only] [--rate HZ] [options of the method]
//
// RECORDINGS holds bnr/ and cmu/. Which clips are tested: recordings.h. Markers are virtual, on a test clip's own body; errors are over the markers
// that are not given. The nearest neighbour is sought among the same markers in the same frame.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "datasets/marker_set.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/marker_estimator.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/benchmarks/recordings.h"

namespace {

using namespace morphograph;

double ProcessorTime_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

// Sums of squares over markers that are not given, and frames.
struct MarkerError {
  double squared = 0, velocity_squared = 0, velocity = 0, distance = 0;
  long long count = 0, velocity_count = 0;
  Eigen::Matrix3Xd last;

  void Add(const Eigen::Matrix3Xd& off, bool first) {
    squared += off.squaredNorm();
    distance += std::sqrt(off.squaredNorm() / static_cast<double>(off.cols()));
    ++count;
    if (!first) {
      velocity_squared += (off - last).squaredNorm();
      velocity += (off - last).colwise().norm().mean();
      ++velocity_count;
    }
    last = off;
  }
  double rms_mm() const { return 1000 * distance / static_cast<double>(count); }
  double gamma_mm() const { return 1000 * velocity / static_cast<double>(velocity_count); }
};

struct Totals {
  MarkerError ours, nearest;
  double microseconds = 0, pose_microseconds = 0, pose_rms = 0, jerk = 0;
  long long pose_frames = 0;
};

void Test(const Split& split, const MotionBase& base, const MarkerModel& fitted, const std::shared_ptr<const MarkerModel>& model, Totals* totals) {
  const Eigen::MatrixXf tracks = MarkerTracks(base, model->markers);
  std::vector<Eigen::Index> given_rows, frame_rows;
  for (const int m : model->given) given_rows.insert(given_rows.end(), {3 * m, 3 * m + 1, 3 * m + 2});
  for (const int m : model->frame_markers.empty() ? model->given : model->frame_markers) frame_rows.insert(frame_rows.end(), {3 * m, 3 * m + 1, 3 * m + 2});
  // Of the base, in the markers' own frame.
  Eigen::MatrixXf inside(tracks.rows(), tracks.cols());
  for (Eigen::Index f = 0; f < tracks.cols(); ++f) {
    const MarkerFrame::Place place = fitted.frame.Fit(tracks(frame_rows, f).cast<double>());
    for (Eigen::Index m = 0; m < tracks.rows(); m += 3) inside.col(f).segment<3>(m) = place.Into(tracks.col(f).segment<3>(m).cast<double>()).cast<float>();
  }
  const Eigen::MatrixXf given = inside(given_rows, Eigen::all);
  std::vector<int> others;
  for (int m = 0; m < static_cast<int>(model->markers.size()); ++m)
    if (std::find(model->given.begin(), model->given.end(), m) == model->given.end()) others.push_back(m);

  for (const Recording& recording : split.unseen) {
    const auto all_markers = FullBodyMarkers({recording.own});
    // Markers are glued on in the mean pose of the clips they are for: of the whole base here, as one subject wears one set. On another body, its own.
    const auto& worn = recording.own.shared_skeleton() == recording.common.shared_skeleton() || SameRestPose(recording.own.skeleton(), recording.common.skeleton())
                           ? model->markers
                           : all_markers;
    const Readings truth = VirtualMarkers(recording.own, worn);
    const Readings reading = VirtualMarkers(recording.own, model->ReadingMarkers());
    MarkerEstimator estimator(model), poser(model);
    std::vector<Eigen::Matrix3Xd> found;
    double start = ProcessorTime_us();
    for (int f = 0; f < recording.own.frame_count(); ++f) found.push_back(estimator.NextMarkers(reading.values.col(f)));
    totals->microseconds += ProcessorTime_us() - start;
    std::vector<BasePose> poses;
    start = ProcessorTime_us();
    for (int f = 0; f < recording.own.frame_count(); ++f) poses.push_back(poser.Next(reading.values.col(f)));
    totals->pose_microseconds += ProcessorTime_us() - start;
    const ReconstructionQuality quality = CompareWithTruth(base, poses, recording.common);
    totals->pose_rms += quality.frames * quality.position_rms_cm;
    totals->jerk += quality.frames * quality.jerk_ratio;
    totals->pose_frames += quality.frames;
    const auto own = static_cast<Eigen::Index>(3 * model->given.size());
    for (int f = 0; f < recording.own.frame_count(); ++f) {
      const Eigen::VectorXd values = reading.values.col(f);
      const MarkerFrame::Place place = fitted.frame.Fit(model->frame_markers.empty() ? values.head(own) : values.tail(values.size() - own));
      Eigen::VectorXf input(own);
      for (Eigen::Index m = 0; m < own; m += 3) input.segment<3>(m) = place.Into(values.segment<3>(m)).cast<float>();
      Eigen::Index nearest = 0;
      (given.colwise() - input).colwise().squaredNorm().minCoeff(&nearest);
      Eigen::Matrix3Xd off(3, others.size()), nearest_off(3, others.size());
      for (std::size_t n = 0; n < others.size(); ++n) {
        const auto column = static_cast<Eigen::Index>(n);
        const Eigen::Vector3d there = truth.values.col(f).segment<3>(3 * others[n]);
        off.col(column) = found[static_cast<std::size_t>(f)].col(others[n]) - there;
        nearest_off.col(column) = place.OutOf(inside.col(nearest).segment<3>(3 * others[n]).cast<double>()) - there;
      }
      totals->ours.Add(off, f == 0);
      totals->nearest.Add(nearest_off, f == 0);
    }
  }
}

void Run(const std::string& title, const std::vector<Split>& splits, const MarkerOptions& options, const MotionBaseOptions& base_options) {
  Totals totals;
  for (const Split& split : splits) {
    const MotionBase base(split.base, {}, base_options);
    const double start = ProcessorTime_us();
    const auto model = std::make_shared<const MarkerModel>(base, FullBodyMarkers(split.base), options);
    std::fprintf(stderr, "%s: %lld frames, %d segments in %d clusters, %.1f s, given:", split.name.c_str(), static_cast<long long>(base.frame_count()),
                 model->segment_count, model->cluster_count, 1e-6 * (ProcessorTime_us() - start));
    for (const int m : model->given) std::fprintf(stderr, " %s", model->markers[static_cast<std::size_t>(m)].name.c_str());
    std::fprintf(stderr, "\n");
    Test(split, base, *model, model, &totals);
  }
  const auto frames = static_cast<double>(totals.pose_frames);
  std::printf("%s, %lld frames tested at %.0f Hz\n", title.c_str(), totals.pose_frames, base_options.frame_rate_hz);
  std::printf("  markers: %.2f mm, nearest neighbour %.2f, ratio %.3f; velocity error %.3f mm/frame, nearest neighbour %.3f, ratio %.3f; %.1f us/frame\n",
              totals.ours.rms_mm(), totals.nearest.rms_mm(), totals.ours.rms_mm() / totals.nearest.rms_mm(), totals.ours.gamma_mm(), totals.nearest.gamma_mm(),
              totals.ours.gamma_mm() / totals.nearest.gamma_mm(), totals.microseconds / frames);
  std::printf("  pose: %.2f cm, jerk %.2f of the truth's; %.1f us/frame\n", totals.pose_rms / frames, totals.jerk / frames, totals.pose_microseconds / frames);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path data;
  bool tune = false, known_only = false, cmu_only = false;
  MarkerOptions options;
  MotionBaseOptions base;
  base.jobs = options.jobs = 2;
  double cmu_rate_hz = 120;
  CLI::App app("All markers from a few");
  app.add_option("--data", data, "folder with bnr and cmu")->required();
  app.add_flag("--tune", tune, "the clips to tune on, not those to test on");
  app.add_flag("--known-only", known_only, "only the splits of known styles and clips");
  app.add_flag("--cmu-only", cmu_only, "only cmu");
  app.add_option("--cmu-rate", cmu_rate_hz, "frames a second of cmu");
  app.add_option("--count", options.selection.count, "markers given");
  app.add_option("--given", options.given, "their names instead")->delimiter(',');
  app.add_option("--frame", options.frame, "names of markers that define the frame, given too")->delimiter(',');
  app.add_option("--history", options.history_s, "seconds");
  app.add_option("--restarts", options.selection.restarts, "of the selection");
  app.add_option("--first", options.segmentation.first_s, "seconds of the first model of a segment");
  app.add_option("--mixture", options.mixture_s, "seconds");
  app.add_option("--tolerance", options.clusters.tolerance, "of clusters");
  app.add_option("--rise", options.segmentation.rise, "of a cut");
  app.add_option("--weight", options.clusters.covariance_weight, "of covariances");
  app.add_option("--most", options.clusters.most_clusters, "clusters");
  app.add_option("--trees", options.forest.trees, "of the forest");
  app.add_option("--depth", options.forest.depth, "of a tree");
  app.add_option("--samples", options.forest.most_samples, "that trees are grown on");
  app.add_option("--ridge", options.ridge, "of the maps");
  CLI11_PARSE(app, argc, argv);
  const Purpose purpose = tune ? Purpose::kTune : Purpose::kTest;
  if (!cmu_only) {
    const auto bnr = LoadRecordings(data / "bnr/dataset-2", {"walk", "walk-turn-left", "walk-turn-right"}, base.frame_rate_hz, false);
    Run("bnr, known style", {KnownStyle(bnr, purpose)}, options, base);
    if (!known_only) Run("bnr, unseen style", UnseenGroups(bnr, 20, purpose), options, base);
  }
  base.frame_rate_hz = cmu_rate_hz;
  const auto cmu = LoadRecordings(data / "cmu", {"07", "08"}, base.frame_rate_hz, true);
  Run("cmu, clip out", {ClipOut(cmu, 4, purpose)}, options, base);
  Run("cmu, each clip out of all", EachClipOut(cmu, 4, purpose), options, base);
  if (!known_only) Run("cmu, unseen subject", UnseenGroups(cmu, 2, purpose), options, base);
}
