#include "synthesis/sensors/marker_estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "primitives/matrix_factors.h"

namespace morphograph {
namespace {

constexpr double kSegmentVariance = 0.99;  // of poses, in the coordinates that segments are cut and clustered in
constexpr Eigen::Index kMostSegmentDimensions = 16;
// Weights below this fade out: a map that adds next to nothing is not worth its time.
constexpr float kLeastWeight = 0.05f;
constexpr int kRounds = 2;  // of the usual places of the frame's markers

std::vector<int> IndicesOf(const std::vector<std::string>& names, const std::vector<Placement>& markers) {
  std::vector<int> indices;
  for (const std::string& name : names) {
    const auto at = std::find_if(markers.begin(), markers.end(), [&](const Placement& marker) { return marker.name == name; });
    if (at == markers.end()) throw std::invalid_argument("MarkerModel: no marker '" + name + "'");
    indices.push_back(static_cast<int>(at - markers.begin()));
  }
  return indices;
}

std::vector<Eigen::Index> RowsOf(const std::vector<int>& markers) {
  std::vector<Eigen::Index> rows;
  for (const int m : markers) rows.insert(rows.end(), {3 * m, 3 * m + 1, 3 * m + 2});
  return rows;
}

// Coordinates of poses in their leading principal components, (dimensions x frames).
Eigen::MatrixXf LeadingCoordinates(const Eigen::MatrixXf& tracks) {
  const Eigen::MatrixXf centred = tracks.colwise() - tracks.rowwise().mean();
  const SymmetricFactors factors = FactorSymmetric((centred * centred.transpose()).cast<double>() / static_cast<double>(tracks.cols()));
  const Eigen::VectorXd values = factors.values.reverse().cwiseMax(0);
  Eigen::Index kept = 0;
  for (double sum = 0; kept < std::min(values.size(), kMostSegmentDimensions) && sum < kSegmentVariance * values.sum(); ++kept) sum += values[kept];
  return factors.vectors.rowwise().reverse().leftCols(std::max<Eigen::Index>(kept, 1)).cast<float>().transpose() * centred;
}

// Cluster of each frame, by its segment. Frames of a clip follow each other.
std::vector<int> ClustersOfFrames(const MotionBase& base, const Eigen::MatrixXf& tracks, const MarkerOptions& options, int* segments_found) {
  const Eigen::MatrixXf coordinates = LeadingCoordinates(tracks);
  std::vector<Eigen::MatrixXd> segments;
  for (Eigen::Index first = 0; first < base.frame_count();) {
    Eigen::Index end = first + 1;
    while (end < base.frame_count() && base.follows(end)) ++end;
    const Eigen::MatrixXd clip = coordinates.middleCols(first, end - first).cast<double>();
    const std::vector<Eigen::Index> cuts = CutMotion(clip, base.frame_rate_hz(), options.segmentation);
    for (std::size_t s = 0; s < cuts.size(); ++s)
      segments.push_back(clip.middleCols(cuts[s], (s + 1 < cuts.size() ? cuts[s + 1] : clip.cols()) - cuts[s]));
    first = end;
  }
  const std::vector<int> of_segment = ClusterSegments(segments, options.clusters);
  std::vector<int> of_frame;
  for (std::size_t s = 0; s < segments.size(); ++s) of_frame.insert(of_frame.end(), static_cast<std::size_t>(segments[s].cols()), of_segment[s]);
  *segments_found = static_cast<int>(segments.size());
  return of_frame;
}

// Ridge regression with an intercept that is not held down: (outputs x (1 + inputs)).
Eigen::MatrixXf LinearMap(const Eigen::MatrixXf& inputs, const Eigen::MatrixXf& outputs, double ridge) {
  const auto count = static_cast<double>(inputs.cols());
  const Eigen::VectorXf in_mean = inputs.rowwise().mean(), out_mean = outputs.rowwise().mean();
  const Eigen::MatrixXf in = inputs.colwise() - in_mean, out = outputs.colwise() - out_mean;
  Eigen::MatrixXd gram = (in * in.transpose()).cast<double>() / count;
  gram.diagonal().array() += ridge * gram.diagonal().mean() + 1e-9;
  const Eigen::MatrixXd slope = gram.llt().solve((in * out.transpose()).cast<double>() / count).transpose();
  Eigen::MatrixXf map(outputs.rows(), 1 + inputs.rows());
  map << out_mean - slope.cast<float>() * in_mean, slope.cast<float>();
  return map;
}

Eigen::VectorXd InFrame(const MarkerFrame::Place& place, const Eigen::Ref<const Eigen::VectorXd>& points) {
  Eigen::VectorXd inside(points.size());
  for (Eigen::Index m = 0; m < points.size(); m += 3) inside.segment<3>(m) = place.Into(points.segment<3>(m));
  return inside;
}

// What maps and forest see: the markers in the frame and, unless `before` is empty, their way since then.
void FillInput(const MarkerFrame::Place& place, const Eigen::Ref<const Eigen::VectorXd>& now, const Eigen::Ref<const Eigen::VectorXd>& before, Eigen::VectorXf* input) {
  input->resize(now.size() + before.size());
  for (Eigen::Index m = 0; m < now.size(); m += 3) {
    const Eigen::Vector3d inside = place.Into(now.segment<3>(m));
    input->segment<3>(m) = inside.cast<float>();
    if (before.size() > 0) input->segment<3>(now.size() + m) = (inside - place.Into(before.segment<3>(m))).cast<float>();
  }
}

// Points of a body whose moving root is above the origin with heading 0, as seen when it was `frames` earlier so: moved and turned back by its steps.
Eigen::VectorXd FromLaterBody(const MotionBase& base, Eigen::Index later, int frames, const Eigen::VectorXd& points) {
  // Root of the earlier frame, seen from the later one's: the steps undone one by one.
  double x = 0, z = 0, heading = 0;
  for (Eigen::Index f = later; f > later - frames; --f) {
    const Eigen::Vector4f step = base.travel().col(f);
    heading -= static_cast<double>(step[2]);
    const double c = std::cos(heading), s = std::sin(heading);
    x -= c * static_cast<double>(step[0]) + s * static_cast<double>(step[1]);
    z -= c * static_cast<double>(step[1]) - s * static_cast<double>(step[0]);
  }
  const MarkerFrame::Place earlier{x, z, std::cos(heading), std::sin(heading)};
  Eigen::VectorXd moved(points.size());
  for (Eigen::Index m = 0; m < points.size(); m += 3) moved.segment<3>(m) = earlier.OutOf(points.segment<3>(m));
  return moved;
}

double Wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace

MarkerModel::MarkerModel(const MotionBase& base, const std::vector<Placement>& full_set, const MarkerOptions& given_options)
    : options(given_options), frame_rate_hz(base.frame_rate_hz()), markers(full_set) {
  if (!(options.ridge > 0) || options.mixture_s < 0) throw std::invalid_argument("MarkerModel: the ridge must be positive and the time not negative");
  const Eigen::MatrixXf tracks = MarkerTracks(base, markers);
  given = options.given.empty() ? PrincipalMarkers(tracks, options.selection) : IndicesOf(options.given, markers);
  frame_markers = IndicesOf(options.frame, markers);
  for (int m = 0; m < static_cast<int>(markers.size()); ++m)
    if (std::find(given.begin(), given.end(), m) == given.end()) others.push_back(m);
  const std::vector<Eigen::Index> frame_rows = RowsOf(frame_markers.empty() ? given : frame_markers), given_rows = RowsOf(given);
  const Eigen::Index frames = base.frame_count();

  // Usual places in the body's frame, then in the frame that they define.
  const Eigen::MatrixXd own = tracks(frame_rows, Eigen::all).cast<double>();
  Eigen::VectorXd usual = own.rowwise().mean();
  for (int round = 0; round < kRounds; ++round) {
    frame = MarkerFrame(usual.reshaped(3, usual.size() / 3));
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(usual.size());
    for (Eigen::Index f = 0; f < frames; ++f) sum += InFrame(frame.Fit(own.col(f)), own.col(f));
    usual = sum / static_cast<double>(frames);
  }
  frame = MarkerFrame(usual.reshaped(3, usual.size() / 3));

  history = static_cast<int>(std::lround(options.history_s * frame_rate_hz));
  std::vector<char> whole(static_cast<std::size_t>(frames), 1);  // frames whose past is in the base
  const auto points_of = [&](Eigen::Index f, Eigen::VectorXd* now, Eigen::VectorXd* before) {
    *now = tracks(given_rows, f).cast<double>();
    if (history == 0) return;
    whole[static_cast<std::size_t>(f)] = f >= history && base.clip_of(f) == base.clip_of(f - history);
    *before = whole[static_cast<std::size_t>(f)] ? FromLaterBody(base, f, history, tracks(given_rows, f - history).cast<double>()) : *now;
  };
  Eigen::MatrixXf inputs(static_cast<Eigen::Index>(given_rows.size()) * (history > 0 ? 2 : 1), frames);
  Eigen::MatrixXf inside(tracks.rows(), frames), poses(base.rotations().rows() + 4, frames);
  Eigen::VectorXd now, before;
  Eigen::VectorXf input;
  for (const bool refined : {false, true}) {
    if (refined && !frame_markers.empty()) break;
    for (Eigen::Index f = 0; f < frames; ++f) {
      points_of(f, &now, &before);
      const MarkerFrame::Place place = FrameOf(own.col(f), now, before, &input);
      inputs.col(f) = input;
      inside.col(f) = InFrame(place, tracks.col(f).cast<double>()).cast<float>();
      const Eigen::Vector3d root = place.Into(Eigen::Vector3d::Zero());
      poses.col(f) << base.rotations().col(f), static_cast<float>(root.x()), static_cast<float>(root.z()), static_cast<float>(-place.heading_rad()), base.travel()(3, f);
    }
    if (!refined && frame_markers.empty()) frame_map = LinearMap(inputs, poses.middleRows(poses.rows() - 4, 3), options.ridge);
  }
  const std::vector<int> cluster_of = ClustersOfFrames(base, inside, options, &segment_count);
  cluster_count = *std::max_element(cluster_of.begin(), cluster_of.end()) + 1;
  if (cluster_count > 1) forest = std::make_unique<ClassForest>(inputs, cluster_of, cluster_count, options.forest);
  const Eigen::MatrixXf wanted = inside(RowsOf(others), Eigen::all);
  for (int k = 0; k < cluster_count; ++k) {
    std::vector<Eigen::Index> members;
    for (Eigen::Index f = 0; f < frames; ++f)
      if (cluster_of[static_cast<std::size_t>(f)] == k && whole[static_cast<std::size_t>(f)]) members.push_back(f);
    if (members.empty()) members.push_back(0);  // clips shorter than the history
    const Eigen::MatrixXf in = inputs(Eigen::all, members);
    marker_maps.push_back(LinearMap(in, wanted(Eigen::all, members), options.ridge));
    pose_maps.push_back(LinearMap(in, poses(Eigen::all, members), options.ridge));
  }
}

MarkerFrame::Place MarkerModel::FrameOf(const Eigen::Ref<const Eigen::VectorXd>& frame_points, const Eigen::Ref<const Eigen::VectorXd>& now,
                                        const Eigen::Ref<const Eigen::VectorXd>& before, Eigen::VectorXf* input) const {
  MarkerFrame::Place place = frame.Fit(frame_points);
  FillInput(place, now, before, input);
  if (frame_map.size() == 0) return place;
  Eigen::Vector3f body = frame_map.col(0);
  body.noalias() += frame_map.rightCols(input->size()) * *input;
  const Eigen::Vector3d origin = place.OutOf({static_cast<double>(body[0]), 0, static_cast<double>(body[1])});
  const double heading = place.heading_rad() + static_cast<double>(body[2]);
  place = {origin.x(), origin.z(), std::cos(heading), std::sin(heading)};
  FillInput(place, now, before, input);
  return place;
}

std::vector<Placement> MarkerModel::ReadingMarkers() const {
  std::vector<Placement> reading;
  for (const int m : given) reading.push_back(markers[static_cast<std::size_t>(m)]);
  for (const int m : frame_markers) reading.push_back(markers[static_cast<std::size_t>(m)]);
  return reading;
}

MarkerEstimator::MarkerEstimator(std::shared_ptr<const MarkerModel> model) : model_(std::move(model)) {
  const auto frames = std::max<Eigen::Index>(1, std::lround(model_->options.mixture_s * model_->frame_rate_hz) + 1);
  recent_.setZero(model_->cluster_count, frames);
  past_.setZero(3 * static_cast<Eigen::Index>(model_->given.size()), model_->history + 1);
}

MarkerFrame::Place MarkerEstimator::Weigh(const Eigen::VectorXd& reading) {
  if (reading.size() != model_->reading_size()) {
    throw std::invalid_argument("MarkerEstimator: a reading of " + std::to_string(reading.size()) + " values, not " + std::to_string(model_->reading_size()));
  }
  const Eigen::Index own = 3 * static_cast<Eigen::Index>(model_->given.size());
  if (count_ == 0) past_.colwise() = reading.head(own).eval();  // as if it had stood
  past_.col(count_ % past_.cols()) = reading.head(own);
  const auto before = past_.col((count_ + 1) % past_.cols());
  const MarkerFrame::Place place = model_->FrameOf(model_->frame_markers.empty() ? reading.head(own) : reading.tail(reading.size() - own), reading.head(own),
                                                   before.head(model_->history > 0 ? own : 0), &input_);
  const Eigen::Index at = count_++;
  if (!model_->forest) {
    weights_ = Eigen::VectorXf::Ones(1);
    return place;
  }
  model_->forest->Probabilities(input_, recent_.col(at % recent_.cols()));
  weights_.noalias() = recent_.rowwise().sum() / static_cast<float>(std::min(count_, recent_.cols()));
  weights_ = (weights_.array() - std::min(kLeastWeight, 0.5f * weights_.maxCoeff())).max(0);
  weights_ /= weights_.sum();
  return place;
}

const Eigen::VectorXf& MarkerEstimator::Mixed(const std::vector<Eigen::MatrixXf>& maps) {
  mixed_.setZero(maps[0].rows());
  for (Eigen::Index k = 0; k < weights_.size(); ++k) {
    if (weights_[k] == 0) continue;
    const Eigen::MatrixXf& map = maps[static_cast<std::size_t>(k)];
    mixed_.noalias() += weights_[k] * (map.rightCols(input_.size()) * input_);
    mixed_ += weights_[k] * map.col(0);
  }
  return mixed_;
}

Eigen::Matrix3Xd MarkerEstimator::NextMarkers(const Eigen::VectorXd& reading) {
  const MarkerFrame::Place place = Weigh(reading);
  const Eigen::VectorXf& inside = Mixed(model_->marker_maps);
  Eigen::Matrix3Xd markers(3, model_->markers.size());
  for (std::size_t n = 0; n < model_->others.size(); ++n)
    markers.col(model_->others[n]) = place.OutOf(inside.segment<3>(3 * static_cast<Eigen::Index>(n)).cast<double>());
  for (std::size_t n = 0; n < model_->given.size(); ++n) markers.col(model_->given[n]) = reading.segment<3>(3 * static_cast<Eigen::Index>(n));
  return markers;
}

BasePose MarkerEstimator::Next(const Eigen::VectorXd& reading) {
  const MarkerFrame::Place frame = Weigh(reading);
  const Eigen::VectorXd mapped = Mixed(model_->pose_maps).cast<double>();
  const Eigen::Index rotations = mapped.size() - 4;
  BasePose pose;
  pose.rotations = mapped.head(rotations);
  pose.height_m = mapped[rotations + 3];
  const Eigen::Vector3d root = frame.OutOf({mapped[rotations], 0, mapped[rotations + 1]});
  const Eigen::Vector2d place(root.x(), root.z());
  const double heading = frame.heading_rad() + mapped[rotations + 2];
  if (moved_) {
    // As BasePose::step: seen from the heading of the frame before.
    const Eigen::Vector2d moved = place - place_;
    const double c = std::cos(heading_rad_), s = std::sin(heading_rad_);
    pose.step = {c * moved.x() - s * moved.y(), s * moved.x() + c * moved.y(), Wrapped(heading - heading_rad_)};
  }
  moved_ = true;
  place_ = place;
  heading_rad_ = heading;
  return pose;
}

}  // namespace morphograph
