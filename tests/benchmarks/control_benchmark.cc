// Steered clips: how well they do what they are asked, how they move, and what they cost (one thread, processor time).
//
//   control_benchmark --model bnr.mgm [--count 50] [--kind path …] [--seed 1] [--out DIR]
//
// Requests are random but seeded, styles in turn. Points to reach come from walks of other seeds from the same start (so that they are
// within reach of the body), moved at random by up to 10 cm.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "datasets/atomic_file.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/forward_kinematics.h"
#include "datasets/quantile.h"
#include "graph/model_io.h"
#include "graph/recorded_motion.h"
#include "synthesis/control/floor_path.h"
#include "synthesis/control/walk_prior.h"
#include "synthesis/motion_synthesizer.h"
#include "synthesis/set_quality.h"
#include "tests/benchmarks/piece_quality.h"

namespace {

using morphograph::SynthesisRequest;
using morphograph::SynthesisResult;
using Rng = std::mt19937_64;
using morphograph::bench::MeanQuality;
using morphograph::bench::MeasurePieces;
using morphograph::bench::MeansByStyle;
using morphograph::bench::PieceQuality;

constexpr size_t kOtherSets = 5;  // of clips that are not steered
constexpr std::uint64_t kOtherSeeds = 5000;  // added, for walks that do not know of each other

double Degrees(double rad) { return rad * 180 / M_PI; }

double Uniform(double low, double high, Rng& rng) { return boost::random::uniform_real_distribution<double>(low, high)(rng); }

// A line of arcs and straights with radii of a metre and more.
std::vector<Eigen::Vector2d> RandomLine(double length_m, Rng& rng) {
  std::vector<Eigen::Vector2d> line = {{0, 0}};
  double heading = 0, left = 0, curvature = 0;
  for (double along = 0; along < length_m; along += 0.1) {
    if (left <= 0) {
      left = Uniform(0.8, 2.5, rng);
      curvature = Uniform(-1, 1, rng);
      if (std::abs(curvature) < 0.3) curvature = 0;
    }
    heading += 0.1 * curvature;
    left -= 0.1;
    line.push_back(line.back() + 0.1 * morphograph::DirectionOfHeading(heading));
  }
  return line;
}

class Requests {
 public:
  Requests(const morphograph::MotionGraph& graph, std::uint64_t seed) : graph_(graph), rng_(seed), styles_(graph.style_names()) {
    for (const std::string& style : styles_) {
      SynthesisRequest request;
      request.style = style;
      std::vector<double> speeds;
      for (std::uint64_t s = 0; s < 10; ++s) {
        request.seed = 900 + s;
        const SynthesisResult clip = Synthesize(graph_, request);
        double way = 0;
        for (size_t f = 1; f < clip.report.path_m.size(); ++f) way += (clip.report.path_m[f] - clip.report.path_m[f - 1]).norm();
        speeds.push_back(way / clip.report.duration_s);
      }
      speeds_[style] = {*std::min_element(speeds.begin(), speeds.end()), *std::max_element(speeds.begin(), speeds.end())};
    }
  }

  SynthesisRequest Make(const std::string& kind, int i) {
    SynthesisRequest request;
    request.seed = static_cast<std::uint64_t>(i);
    if (!styles_.empty()) request.style = styles_[static_cast<size_t>(i) % styles_.size()];
    const auto [slow, fast] = styles_.empty() ? std::pair(1.0, 1.4) : speeds_[*request.style];
    if (kind == "free") {  // nothing: what chance does
      request.duration_s = 10;
      request.seed += kOtherSeeds;
    } else if (kind == "path") {
      request.control.path = {.points_m = RandomLine(10 * (slow + fast) / 2, rng_), .smooth = true};
    } else if (kind == "tight_bend") {  // radii under a metre
      const double side = i % 2 == 0 ? 1 : -1;
      request.control.path = {.points_m = {{0, 0}, {0, 2}, {side * 1.2, 3.4}, {side * 0.5, 5}, {-side, 5.5}}, .smooth = true};
      for (size_t k = 2; k < 5; ++k) request.control.path->points_m[k] += Direction(M_PI) * Uniform(0, 0.1, rng_);
    } else if (kind == "polyline") {
      request.control.path = {.points_m = {{0, 0}, {2, 0}, {4, 3}}};
    } else if (kind == "goal") {
      request.control.goal = {.position_m = Direction(0.8) * Uniform(3, 6, rng_), .tolerance_m = 0.02, .heading_tolerance_rad = 3 * M_PI / 180};
      request.start_given.heading = true;
      request.control.goal->heading_rad = Uniform(-1, 1, rng_);
    } else if (kind == "arrival") {
      const double length = Uniform(5, 9, rng_);
      request.control.goal = {.position_m = {0, length}, .tolerance_m = 0.02, .time_s = length / Uniform(slow, fast, rng_)};
    } else if (kind == "speed") {
      request.control.path = {.points_m = {{0, 0}, {0, 8}}};
      request.control.speed = {.profile = {{0, Uniform(slow, fast, rng_)}}};
    } else if (kind == "heading") {
      request.duration_s = 6;
      request.control.constraints.push_back(morphograph::HeadingTerm{.at = {.time_s = 4}, .value_rad = Uniform(-1, 1, rng_), .tolerance_rad = 3 * M_PI / 180});
    } else if (kind == "footstep") {
      request.duration_s = 5;
      const SynthesisResult other = Other(request);
      morphograph::FootstepTerm term{.left = i % 2 == 0, .index = 3, .tolerance_m = 0.02};
      int index = 0;
      for (const auto& foot : other.report.contacts) {
        if ((foot.interval.foot == morphograph::Foot::kLeft) == term.left && index++ == term.index) term.value_m = foot.position_m + Direction(M_PI) * Uniform(0, 0.1, rng_);
      }
      request.control.constraints.push_back(term);
    } else if (kind == "wrist") {
      request.duration_s = 5;
      const SynthesisResult other = Other(request);
      const double time = std::round(Uniform(1.5, 4, rng_) * 30) / 30;
      const auto role = i % 2 == 0 ? morphograph::JointRole::kLeftWrist : morphograph::JointRole::kRightWrist;
      const Eigen::Vector3d there =
          ForwardKinematics(other.clip, static_cast<int>(std::lround(time * 30))).positions.col(graph_.skeleton().roles()[role]);
      const Eigen::Vector3d moved = Eigen::Vector3d(Uniform(-1, 1, rng_), Uniform(-1, 1, rng_), Uniform(-1, 1, rng_)).normalized() * Uniform(0, 0.1, rng_);
      request.control.constraints.push_back(morphograph::PositionTerm{.joint = i % 2 == 0 ? "left_wrist" : "right_wrist", .at = {.time_s = time}, .value_m = there + moved, .tolerance_m = 0.015});
    } else if (kind == "keep_out") {
      request.control.goal = {.position_m = {0, 6}, .tolerance_m = 0.02};
      request.control.constraints.push_back(morphograph::KeepOutTerm{.center_m = {Uniform(-0.6, 0.6, rng_), Uniform(2.5, 3.5, rng_)}, .radius_m = 0.5});
    } else if (kind == "look_at") {
      request.duration_s = 5;
      request.control.constraints.push_back(morphograph::LookAtTerm{.from_s = 1.5, .to_s = 3, .value_m = {Uniform(-2, 2, rng_), 1.5, 8}});
    } else {
      throw std::runtime_error("no requests of kind '" + kind + "'");
    }
    return request;
  }

 private:
  Eigen::Vector2d Direction(double range) { return morphograph::DirectionOfHeading(Uniform(-range, range, rng_)); }

  SynthesisResult Other(SynthesisRequest request) const {
    request.seed += kOtherSeeds;
    return Synthesize(graph_, request);
  }

  const morphograph::MotionGraph& graph_;
  Rng rng_;
  std::vector<std::string> styles_;
  std::map<std::string, std::pair<double, double>> speeds_;
};

// ln p of captured steps after the ones before them, by style and sorted: of the training's residuals, each taken on a clip that its transition
// had not seen.
std::map<std::string, std::vector<double>> CapturedLikelihoods(const morphograph::MotionGraph& graph) {
  std::map<std::string, std::vector<double>> of_style;
  for (int e = 0; e < graph.edge_count(); ++e) {
    const morphograph::TransitionModel& transition = graph.transition(e);
    morphograph::WalkStep previous, next;
    previous.primitive = graph.edge_from(e);
    next.primitive = graph.edge_to(e);
    next.edge = e;
    if (!IsSteady(graph.primitive(previous.primitive)) || !IsSteady(graph.primitive(next.primitive))) continue;
    for (morphograph::WalkStep* step : {&previous, &next}) {
      step->manner.m.resize(static_cast<size_t>(graph.primitive_count()));
      for (int p = 0; p < graph.primitive_count(); ++p)
        step->manner.m[static_cast<size_t>(p)] = Eigen::VectorXd::Zero(graph.primitive(p).reduction.components());
    }
    const Eigen::VectorXd at = Eigen::VectorXd::Zero(graph.primitive(previous.primitive).reduction.components());
    for (Eigen::Index i = 0; i < transition.residuals.cols(); ++i) {
      next.component = transition.residual_component[static_cast<size_t>(i)];
      previous.component = 0;
      transition.component_chances.col(next.component).maxCoeff(&previous.component);
      const Eigen::VectorXd within = transition.Mean(at) + transition.residuals.col(i).cast<double>();
      const Eigen::VectorXd latent = WithinWalkOf(graph, next).scale.cwiseProduct(within);
      of_style[graph.primitive(next.primitive).style].push_back(morphograph::StepInnovation(graph, previous, next).LogLikelihood(at, latent));
    }
  }
  for (auto& [style, values] : of_style) std::sort(values.begin(), values.end());
  return of_style;
}

// Part of the values that lie below, 0 to 1.
double Rank(const std::vector<double>& sorted, double value) {
  return static_cast<double>(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin()) / static_cast<double>(std::max<size_t>(1, sorted.size()));
}

struct Tally {
  std::map<std::string, std::vector<double>> residuals;  // by pointer
  std::map<std::string, std::string> units;
};

// What the model was learned from, where it keeps that.
std::vector<PieceQuality> CapturedPieces(const morphograph::MotionGraph& graph) {
  if (!graph.recordings()) return {};
  return MeasurePieces(RecordedClips(*graph.recordings(), graph.layout(), graph.styles()[0].mean_rotations));
}

// A measure of steered clips, in its mean over sets of clips that were told nothing, and these sets themselves in that: what is chance.
void PrintBesideChance(const char* what, double steered, const std::vector<double>& free) {
  double mean = 0;
  for (const double value : free) mean += value / static_cast<double>(free.size());
  const auto [least, most] = std::minmax_element(free.begin(), free.end());
  std::printf(" %s %.2f (%.2f to %.2f)", what, steered / mean, *least / mean, *most / mean);
}

// How steered clips move, beside clips of the same styles that were told nothing: of the same seeds first, then of these and others.
void PrintQuality(const std::vector<morphograph::MotionClip>& steered, const std::vector<morphograph::MotionClip>& free,
                  const std::vector<std::vector<morphograph::MotionClip>>& others, const std::vector<int>& requests, const std::vector<PieceQuality>& captured) {
  const morphograph::SetQuality a = MeasureSet(steered), b = MeasureSet(free);
  std::printf("  steered / not: contact %.2f (%.2f mm), skate %.2f, naturalness %.2f, acceleration %.2f, jerk %.2f; knees %.1f (%.1f) deg\n",
              a.contact_distance_m / b.contact_distance_m, 1000 * a.contact_distance_m, a.foot_skate_cm_s / b.foot_skate_cm_s, a.naturalness / b.naturalness,
              a.acceleration_p999_m_s2 / b.acceleration_p999_m_s2, a.mean_jerk_m_s3 / b.mean_jerk_m_s3, a.min_knee_flexion_deg, b.min_knee_flexion_deg);
  std::vector<morphograph::SetQuality> sets = {b};
  for (const auto& other : others) sets.push_back(MeasureSet(other));
  const auto beside = [&](const char* what, double morphograph::SetQuality::*measure) {
    std::vector<double> values;
    for (const morphograph::SetQuality& set : sets) values.push_back(set.*measure);
    PrintBesideChance(what, a.*measure, values);
  };
  std::printf("  steered / mean of %zu sets that are not (these sets / their mean):", sets.size());
  beside("contact", &morphograph::SetQuality::contact_distance_m);
  beside("skate", &morphograph::SetQuality::foot_skate_cm_s);
  beside("naturalness", &morphograph::SetQuality::naturalness);
  beside("acceleration", &morphograph::SetQuality::acceleration_p999_m_s2);
  std::printf("\n");
  constexpr double kStraight_rad = 0.35, kTurn_rad = 0.7, kAny = 100;
  const std::vector<PieceQuality> pieces = MeasurePieces(steered);
  const auto of_steered = MeansByStyle(pieces, 0, kAny), of_free = MeansByStyle(MeasurePieces(free), 0, kAny);
  const auto of_straight = MeansByStyle(captured, 0, kStraight_rad), of_turns = MeansByStyle(captured, kTurn_rad, kAny);
  MeanQuality straight, turns;  // sums, each style as often as among the steered pieces
  for (const auto& [style, s] : of_steered) {
    const MeanQuality& f = of_free.at(style);
    std::printf("    %-10s turns %.0f (%.0f) deg, %.2f (%.2f) m/s, contact %.2f (%.2f mm), skate %.2f, naturalness %.2f", style.c_str(), Degrees(s.turn_rad), Degrees(f.turn_rad), s.speed_m_s,
                f.speed_m_s, s.contact_m / f.contact_m, 1000 * s.contact_m, s.skate_cm_s / f.skate_cm_s, s.naturalness / f.naturalness);
    if (of_straight.contains(style) && of_turns.contains(style)) {
      const MeanQuality &a_line = of_straight.at(style), &a_turn = of_turns.at(style);
      std::printf("; captured turns of %.0f / walks of %.0f deg: contact %.2f, skate %.2f, naturalness %.2f", Degrees(a_turn.turn_rad), Degrees(a_line.turn_rad), a_turn.contact_m / a_line.contact_m,
                  a_turn.skate_cm_s / a_line.skate_cm_s, a_turn.naturalness / a_line.naturalness);
      straight.Add(a_line, s.pieces);
      turns.Add(a_turn, s.pieces);
    }
    std::printf("\n");
  }
  if (straight.pieces > 0) {
    std::printf("  captured turns / straight walks, styles as often as here: contact %.2f, skate %.2f, naturalness %.2f\n", turns.contact_m / straight.contact_m, turns.skate_cm_s / straight.skate_cm_s,
                turns.naturalness / straight.naturalness);
  }
  const auto worst = [&](const char* what, auto value) {
    std::vector<PieceQuality> sorted = pieces;
    std::stable_sort(sorted.begin(), sorted.end(), [&](const PieceQuality& x, const PieceQuality& y) { return value(x) > value(y); });
    std::printf("    most %s, parts of all:", what);
    double sum = 0;
    for (const PieceQuality& piece : pieces) sum += value(piece);
    for (size_t i = 0; i < std::min<size_t>(5, sorted.size()); ++i)
      std::printf(" %.2f (request %d, %s, turns %.0f deg)", value(sorted[i]) / sum, requests[static_cast<size_t>(sorted[i].clip)], sorted[i].style.c_str(), Degrees(sorted[i].turn_rad));
    std::printf("\n");
  };
  worst("contact distance", [](const PieceQuality& piece) { return piece.contact_m; });
  worst("naturalness", [](const PieceQuality& piece) { return piece.naturalness; });
}

// The largest swings of clips, in those that 99 of 100 captured steps of the style keep to.
void PrintSwings(const char* what, const std::vector<morphograph::MotionClip>& clips, const std::map<std::string, morphograph::ClipSwing>& captured) {
  const std::vector<morphograph::ClipSwing> swings = morphograph::bench::MeasureSwings(clips);
  std::vector<double> speeds, heights;
  for (size_t i = 0; i < clips.size(); ++i) {
    const auto known = captured.find(clips[i].style);
    if (known == captured.end()) return;
    speeds.push_back(swings[i].speed_m_s / known->second.speed_m_s);
    heights.push_back(swings[i].height_m / known->second.height_m);
  }
  const auto beyond = std::count_if(speeds.begin(), speeds.end(), [](double part) { return part > 1.1; });
  std::printf("  largest swing of a clip / what 99 of 100 captured steps keep to, %s: speed median %.2f, largest %.2f, above 1.1 in %d of %d; height of the ball median %.2f, largest %.2f\n",
              what, morphograph::Median(speeds), morphograph::Quantile(speeds, 1), static_cast<int>(beyond), static_cast<int>(speeds.size()), morphograph::Median(heights),
              morphograph::Quantile(heights, 1));
}

void Run(const morphograph::MotionGraph& graph, const std::string& kind, int count, std::uint64_t seed, const std::string& out,
         const std::vector<PieceQuality>& captured_pieces) {
  Requests requests(graph, seed);
  Tally tally;
  const auto captured = CapturedLikelihoods(graph);
  std::vector<double> ms, path_mean, path_95, ranks;
  std::vector<morphograph::MotionClip> clips, free;
  std::vector<std::vector<morphograph::MotionClip>> others(kOtherSets);
  std::vector<int> numbers;  // of the requests that were met
  int met = 0;
  for (int i = 0; i < count; ++i) {
    const SynthesisRequest request = requests.Make(kind, i);
    const std::clock_t started = std::clock();
    try {
      SynthesisResult result = Synthesize(graph, request);
      ms.push_back(1e3 * static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC);
      ++met;
      for (const morphograph::ControlOutcome& outcome : result.report.constraints) {
        // A path's end is called after its last point, whose number differs from line to line.
        const bool is_end = outcome.pointer.starts_with("/path/points/");
        const std::string pointer = is_end ? "/path/points/-" : outcome.pointer;
        tally.residuals[pointer].push_back(outcome.residual);
        tally.units[pointer] = outcome.unit;
      }
      for (const morphograph::StepReport& step : result.report.steps) {
        if (const auto found = captured.find(result.report.style); found != captured.end()) ranks.push_back(Rank(found->second, step.log_likelihood));
      }
      if (request.control.path) {
        const morphograph::FloorPath path(request.control.path->points_m, request.control.path->smooth);
        std::vector<double> distances;
        for (const Eigen::Vector2d& root : result.report.path_m) distances.push_back(path.NearestTo(root).distance_m);
        double sum = 0;
        for (const double d : distances) sum += d;
        path_mean.push_back(sum / static_cast<double>(distances.size()));
        path_95.push_back(morphograph::Quantile(distances, 0.95));
      }
      if (!out.empty()) morphograph::WriteFileAtomically(std::filesystem::path(out) / (kind + std::to_string(i) + ".bvh"), WriteBvh(ExportClip(result.clip)));
      SynthesisRequest unsteered;
      unsteered.seed = request.seed;
      unsteered.style = request.style;
      unsteered.duration_s = result.report.duration_s;
      free.push_back(Synthesize(graph, unsteered).clip);
      unsteered.seed += kOtherSeeds;  // the first are those that goals are taken from
      for (auto& other : others) {
        unsteered.seed += kOtherSeeds;
        other.push_back(Synthesize(graph, unsteered).clip);
      }
      numbers.push_back(i);
      clips.push_back(std::move(result.clip));
    } catch (const morphograph::UnsatisfiableRequest& unmet) {
      ms.push_back(1e3 * static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC);
      for (const auto& field : unmet.unmet()) {
        std::printf("  %d: %s %s", i, field.pointer.c_str(), field.detail.c_str());
        if (kind == "wrist") {
          const auto& term = std::get<morphograph::PositionTerm>(request.control.constraints[0]);
          std::printf("; asked for [%.3f, %.3f, %.3f] at %.2f s", term.value_m.x(), term.value_m.y(), term.value_m.z(), *term.at.time_s);
        }
        std::printf("\n");
      }
    }
  }
  std::printf("%-10s met %d of %d; ms median %.1f, 90 %% %.1f, 99 %% %.1f", kind.c_str(), met, count, morphograph::Median(ms), morphograph::Quantile(ms, 0.9),
              morphograph::Quantile(ms, 0.99));
  if (!ranks.empty()) std::printf("; ln p a step among captured ones: median at %.0f %%", 100 * morphograph::Median(ranks));
  std::printf("\n");
  for (auto& [pointer, residuals] : tally.residuals) {
    const double scale = tally.units[pointer] == "rad" ? 180 / M_PI : tally.units[pointer] == "m" ? 100 : 1;
    const char* unit = tally.units[pointer] == "rad" ? "deg" : tally.units[pointer] == "m" ? "cm" : tally.units[pointer].c_str();
    std::printf("  %-16s median %.2f, 95 %% %.2f, largest %.2f %s\n", pointer.c_str(), scale * morphograph::Median(residuals),
                scale * morphograph::Quantile(residuals, 0.95), scale * morphograph::Quantile(residuals, 1), unit);
  }
  if (!path_mean.empty()) {
    std::printf("  distance from path: median over clips of the mean %.2f cm, of 95 %% %.2f cm; worst clip %.2f, %.2f\n", 100 * morphograph::Quantile(path_mean, 0.5),
                100 * morphograph::Median(path_95), 100 * morphograph::Quantile(path_mean, 1), 100 * morphograph::Quantile(path_95, 1));
  }
  const auto swings = morphograph::bench::CapturedSwings(graph);
  PrintSwings("steered", clips, swings);
  PrintSwings("not steered", free, swings);
  if (clips.size() >= 5) PrintQuality(clips, free, others, numbers, captured_pieces);
}

}  // namespace

int main(int argc, char** argv) {
  std::string model, out;
  std::vector<std::string> kinds = {"path", "tight_bend", "polyline", "goal", "arrival", "speed", "heading", "footstep", "wrist", "keep_out", "look_at"};
  int count = 50;
  std::uint64_t seed = 1;
  CLI::App app("Steered clips: accuracy, motion, time");
  app.add_option("--model", model, "a model file")->required();
  app.add_option("--kind", kinds, "kinds of requests");
  app.add_option("--count", count, "requests of each kind");
  app.add_option("--seed", seed, "of the requests");
  app.add_option("--out", out, "folder for the clips");
  CLI11_PARSE(app, argc, argv);
  try {
    const auto graph = morphograph::LoadModel(model);
    const std::vector<PieceQuality> captured = CapturedPieces(*graph);
    for (const std::string& kind : kinds) Run(*graph, kind, count, seed, out, captured);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "control_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
