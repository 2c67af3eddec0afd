// Motion quality of a model, or of any set of clips, against captured clips (METHODS section 6).
//
//   quality_benchmark --data bnr/walk bnr/turns --model bnr.mgm   synthesised, style by style
//   quality_benchmark --data bnr/walk bnr/turns --set drawn/      a folder of BVH
//   quality_benchmark --data bnr/walk bnr/turns                   the captured clips themselves, and controls
//   … --auc 6                                                     with a forest's AUC and its floor, over 6 halvings
//
// Captured and synthesised clips go through the same code. Figures that depend on the length of a clip are
// taken on pieces of equal length. The Fréchet distance is given as a ratio to the one between two random
// halves of the captured clips (mean of 20 halvings); it is squared and falls with the number of clips, so a
// half against a half, or any faithful large set, comes out under 1. What leaves the 32 leading directions is
// not in it: see the residual beside it (resid., ratio of mean squared distances from them).

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/bvh_reader.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/dataset_loader.h"
#include "datasets/quantile.h"
#include "datasets/resample.h"
#include "graph/graph_summary.h"
#include "graph/model_io.h"
#include "synthesis/body_check.h"
#include "synthesis/clip_ends.h"
#include "synthesis/evaluation.h"
#include "synthesis/motion_synthesizer.h"
#include "synthesis/pose_windows.h"
#include "synthesis/set_quality.h"
#include "synthesis/smoothness.h"
#include "synthesis/style_classifier.h"
#include "synthesis/window_classifier.h"

namespace {

using morphograph::MotionClip;

struct Options {
  std::vector<std::filesystem::path> data, set;
  std::string model;
  int clips = 100;
  double duration_s = 10;
  int sanity = 1000;
  int trim = 30;
  int piece = 90;
  int auc = 0;  // halvings; 0: none
  int jobs = 2;
  std::uint64_t seed = 1;
};

// Clips of one kind, with all that is compared of them.
struct Set {
  std::vector<MotionClip> clips;
  std::vector<Eigen::MatrixXd> windows;
  morphograph::SetQuality quality;
};

Set Prepare(std::vector<MotionClip> clips, const Options& options) {
  Set set;
  set.quality = morphograph::MeasureSet(clips, {.piece_frames = options.piece});
  for (const MotionClip& clip : clips) {
    set.windows.push_back(morphograph::PoseWindows(morphograph::PrepareEvaluation(clip)));
  }
  set.clips = std::move(clips);
  return set;
}

void PrintHeader() {
  std::printf("%-26s %5s %7s | %7s %8s %8s %8s %8s | %8s %8s %7s %7s | %7s\n", "set", "clips", "windows",
              "contact", "natural.", "skate", "acc 99.9", "jerk", "Frechet", "halves", "ratio", "resid.",
              "divers.");
}

void PrintAbsolute(const std::string& name, const Set& set) {
  const auto& q = set.quality;
  int windows = 0;
  for (const auto& of_clip : set.windows) windows += static_cast<int>(of_clip.cols());
  std::printf("%-26s %5d %7d | %5.2fmm %8.2e %4.2fcm/s %5.1fm/s2 %8.1f |\n", name.c_str(), q.clips, windows,
              1000 * q.contact_distance_m, q.naturalness, q.foot_skate_cm_s, q.acceleration_p999_m_s2,
              q.mean_jerk_m_s3);
}

morphograph::SetComparison PrintAgainst(const std::string& name, const Set& set, const Set& reference,
                                        std::uint64_t seed) {
  const auto comparison = morphograph::CompareWindowSets(set.windows, reference.windows, seed);
  const auto &a = set.quality, &b = reference.quality;
  std::printf("%-26s %5d %7d | %7.3f %8.3f %8.3f %8.3f %8.3f | %8.4f %8.4f %7.2f %7.2f | %7.3f\n",
              name.c_str(), a.clips, comparison.windows, a.contact_distance_m / b.contact_distance_m,
              a.naturalness / b.naturalness, a.foot_skate_cm_s / b.foot_skate_cm_s,
              a.acceleration_p999_m_s2 / b.acceleration_p999_m_s2, a.mean_jerk_m_s3 / b.mean_jerk_m_s3,
              comparison.frechet, comparison.frechet_halves, comparison.frechet_ratio,
              comparison.residual_ratio, comparison.diversity / comparison.diversity_reference);
  return comparison;
}

// A forest's AUC between set and captured clips beside the floor; nothing unless asked for: it takes a second a halving.
void PrintAuc(const std::string& name, const std::vector<MotionClip>& set, const std::vector<MotionClip>& captured,
              const Options& options) {
  if (options.auc == 0) return;
  const morphograph::WindowDistinction told =
      TellApart(set, captured, {.halvings = options.auc, .seed = options.seed, .jobs = options.jobs});
  std::printf("%-26s %7d windows | AUC %.3f floor %.3f above it %+.3f (+- %.3f)\n", name.c_str(), told.windows, told.auc,
              told.floor, told.difference, told.standard_error);
}

void PrintBody(const std::string& name, const Set& set) {
  const auto& q = set.quality;
  std::printf(
      "%-26s knee flexion %.1f .. %.1f deg; lowest foot point %.1f mm under the contact plane; bones "
      "constant to %.1e m\n",
      name.c_str(), q.min_knee_flexion_deg, q.max_knee_flexion_deg, -1000 * q.lowest_m,
      q.bone_length_error_m);
}

void PrintConfusion(const std::string& title, const morphograph::StyleConfusion& confusion) {
  std::printf("%s: %.1f %% right\n", title.c_str(), 100 * confusion.accuracy);
  for (size_t row = 0; row < confusion.styles.size(); ++row) {
    std::printf("  %-12s", confusion.styles[row].c_str());
    for (Eigen::Index column = 0; column < confusion.counts.cols(); ++column) {
      std::printf(" %4d", confusion.counts(static_cast<Eigen::Index>(row), column));
    }
    std::printf("\n");
  }
}

std::vector<morphograph::StyledWindows> Styled(const std::map<std::string, Set>& sets) {
  std::vector<morphograph::StyledWindows> styled;
  for (const auto& [style, set] : sets) {
    for (const Eigen::MatrixXd& windows : set.windows) {
      if (windows.cols() >= 2) styled.push_back({style, windows});
    }
  }
  return styled;
}

std::map<std::string, Set> ByStyle(const std::vector<MotionClip>& clips, const Options& options) {
  std::map<std::string, std::vector<MotionClip>> sorted;
  for (const MotionClip& clip : clips) sorted[clip.style].push_back(clip);
  std::map<std::string, Set> sets;
  for (auto& [style, of_style] : sorted) sets[style] = Prepare(std::move(of_style), options);
  return sets;
}

// Every rotation of the clip disturbed by white noise of `sigma_rad`: a control that must be told from the
// capture.
MotionClip Noisy(MotionClip clip, double sigma_rad, std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal(0, sigma_rad);
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (int j = clip.skeleton().moving_root(); j < clip.joint_count(); ++j) {
      const Eigen::Vector3d turn(normal(rng), normal(rng), normal(rng));
      if (turn.norm() > 0) {
        clip.rotation(f, j) =
            (clip.rotation(f, j) * Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())));
      }
    }
  }
  return clip;
}

void PrintHalves(const std::string& name, const std::vector<MotionClip>& clips, const Options& options,
                 std::mt19937_64& rng) {
  std::vector<size_t> order(clips.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[boost::random::uniform_int_distribution<size_t>(0, i - 1)(rng)]);
  }
  std::vector<MotionClip> halves[2];
  for (size_t i = 0; i < order.size(); ++i) halves[i % 2].push_back(clips[order[i]]);
  PrintAgainst(name, Prepare(halves[0], options), Prepare(halves[1], options), options.seed);
}

// The captured clips against themselves, and controls. Shows that the measures do measure.
void SelfCheck(const std::vector<MotionClip>& captured, const Set& all,
               const std::map<std::string, Set>& by_style, const Options& options) {
  std::mt19937_64 rng(options.seed);
  std::printf("\none random half of the captured clips / the other half\n");
  PrintHeader();
  PrintHalves("all", captured, options, rng);
  for (const auto& [style, set] : by_style) {
    if (by_style.size() > 1) PrintHalves(style, set.clips, options, rng);
  }
  std::vector<MotionClip> noisy;
  for (const MotionClip& clip : captured) noisy.push_back(Noisy(clip, 0.02, rng));
  std::printf("\ncontrols that must be told from captured clips\n");
  PrintHeader();
  PrintAgainst("noise of 0.02 rad / all", Prepare(noisy, options), all, options.seed);
  for (const auto& [style, set] : by_style) {
    if (by_style.size() > 1) PrintAgainst("all styles / " + style, all, set, options.seed);
  }
  for (const auto& [style, set] : by_style) {
    std::vector<MotionClip> disturbed;
    for (const MotionClip& clip : set.clips) disturbed.push_back(Noisy(clip, 0.02, rng));
    PrintAuc("noise of 0.02 rad / " + style, disturbed, set.clips, options);
    if (by_style.size() > 1) {
      const auto& other = &set == &by_style.begin()->second ? *by_style.rbegin() : *by_style.begin();
      PrintAuc(other.first + " / " + style, other.second.clips, set.clips, options);
    }
  }
}

std::vector<MotionClip> Draw(const morphograph::MotionGraph& graph, const std::optional<std::string>& style,
                             int count, const Options& options) {
  std::vector<MotionClip> clips;
  for (int i = 0; i < count; ++i) {
    morphograph::SynthesisRequest request;
    request.seed = options.seed + static_cast<std::uint64_t>(i);
    request.style = style;
    request.duration_s = options.duration_s;
    clips.push_back(morphograph::Synthesize(graph, request).clip);
    clips.back().style = style.value_or("");
  }
  return clips;
}

// Draws clips, writes and reads each as BVH, and counts what no body could do. False when any could not.
//
// Limits come from the capture where a sound walk is not exactly zero: a knee may straighten as far as
// captured ones, and a foot point may dip under the contact plane as deep as captured ones (a foot that rolls
// turns its ball joint below its standing height). The floor itself is y = 0, where training puts it.
bool SanityCheck(const morphograph::MotionGraph& graph, const std::vector<std::string>& styles,
                 const morphograph::SetQuality& captured, const Options& options) {
  const double knee_limit = std::min(0.0, captured.min_knee_flexion_deg) - 1;
  const double plane_limit = std::min(0.0, captured.lowest_m) - 0.01;
  int not_finite = 0, knees = 0, bones = 0, floor = 0, plane = 0;
  double lowest_joint = 1, lowest = 0, knee = 180, bone = 0;
  for (int i = 0; i < options.sanity; ++i) {
    morphograph::SynthesisRequest request;
    request.seed = 100000 + static_cast<std::uint64_t>(i);
    if (!styles.empty()) request.style = styles[static_cast<size_t>(i) % styles.size()];
    request.duration_s = options.duration_s;
    const MotionClip drawn = morphograph::Synthesize(graph, request).clip;
    bool finite = drawn.root_positions().allFinite();
    for (int f = 0; f < drawn.frame_count() && finite; ++f) {
      for (int j = 0; j < drawn.joint_count(); ++j)
        finite = finite && drawn.rotation(f, j).coeffs().allFinite();
    }
    if (!finite) {
      ++not_finite;
      continue;
    }
    const std::string text = morphograph::WriteBvh(morphograph::ExportClip(drawn));
    // What a reader makes of the file, in place of what we meant. Leading frames are motion here, never a
    // rest pose.
    const MotionClip clip =
        morphograph::ImportClip(morphograph::ParseBvh(text, "drawn.bvh"), {.drop_leading_rest = false});
    const morphograph::EvaluationMotion motion = morphograph::PrepareEvaluation(clip);
    const morphograph::BodyCheck body = morphograph::CheckBody(motion);
    double lowest_here = 1;
    for (const Eigen::Matrix3Xd& positions : motion.joint_positions) {
      for (int j = clip.skeleton().moving_root(); j < clip.joint_count(); ++j) {
        lowest_here = std::min(lowest_here, positions(1, j));
      }
    }
    for (int side = 0; side < 2; ++side) {
      lowest_here = std::min(lowest_here, motion.contacts.heels[side].row(1).minCoeff());
    }
    knees += body.min_knee_flexion_deg < knee_limit;
    bones += body.bone_length_error_m > 1e-4;
    floor += lowest_here < -0.01;
    plane += body.lowest_m < plane_limit;
    lowest_joint = std::min(lowest_joint, lowest_here);
    lowest = std::min(lowest, body.lowest_m);
    knee = std::min(knee, body.min_knee_flexion_deg);
    bone = std::max(bone, body.bone_length_error_m);
  }
  std::printf("\n%d clips of %.0f s written and read as BVH, clips at fault:\n", options.sanity,
              options.duration_s);
  std::printf("  %4d not finite\n", not_finite);
  std::printf("  %4d with a knee bent back (least flexion %.1f deg, limit %.1f: captured - 1)\n", knees, knee,
              knee_limit);
  std::printf("  %4d with bones that change (at most %.1e m)\n", bones, bone);
  std::printf("  %4d with a joint or heel more than 1 cm under the floor y = 0 (lowest %.1f mm)\n", floor,
              1000 * lowest_joint);
  std::printf(
      "  %4d with a foot more than 1 cm deeper under the contact plane than captured (lowest %.1f mm, limit "
      "%.1f)\n",
      plane, 1000 * lowest, 1000 * plane_limit);
  return not_finite + knees + bones + floor + plane == 0;
}

void TimeSampling(const morphograph::MotionGraph& graph, const Options& options) {
  std::vector<double> motion, report, text;  // the report is part of every synthesis; it is timed once more by itself
  for (int i = 0; i < 100; ++i) {
    morphograph::SynthesisRequest request;
    request.seed = static_cast<std::uint64_t>(i);
    request.duration_s = options.duration_s;
    const std::clock_t start = std::clock();
    const morphograph::SynthesisResult result = morphograph::Synthesize(graph, request);
    const std::clock_t drawn = std::clock();
    const std::string bvh = morphograph::WriteBvh(morphograph::ExportClip(result.clip));
    const std::clock_t written = std::clock();
    morphograph::EvaluateClip(result.clip);
    report.push_back(1e3 * static_cast<double>(std::clock() - written) / CLOCKS_PER_SEC);
    motion.push_back(1e3 * static_cast<double>(drawn - start) / CLOCKS_PER_SEC);
    text.push_back(1e3 * static_cast<double>(written - start) / CLOCKS_PER_SEC);
  }
  std::printf(
      "a clip of %.0f s, processor time, median of 100: motion and report %.2f ms, of these the report %.2f ms; "
      "with BVH text %.2f ms\n",
      options.duration_s, morphograph::Median(motion), morphograph::Median(report), morphograph::Median(text));
}

bool JudgeModel(const Set& all, const std::map<std::string, Set>& captured, const Set& all_whole,
                const std::map<std::string, Set>& captured_whole, const Options& options) {
  const auto graph = morphograph::LoadModel(options.model);
  const std::vector<std::string> styles = morphograph::Summarise(*graph).styles;
  std::map<std::string, Set> drawn;
  std::printf("\nsynthesised / captured: %d clips of %.0f s a style, seeds from %llu\n", options.clips,
              options.duration_s, static_cast<unsigned long long>(options.seed));
  const Set pooled = Prepare(Draw(*graph, std::nullopt, options.clips, options), options);
  for (const std::string& style : styles) {
    if (captured.count(style)) drawn[style] = Prepare(Draw(*graph, style, options.clips, options), options);
  }
  for (const bool whole : {false, true}) {
    std::printf("%s\n", whole ? "captured clips as they are" : "captured clips trimmed at both ends");
    PrintHeader();
    PrintAgainst("no style asked / all", pooled, whole ? all_whole : all, options.seed);
    for (const auto& [style, set] : drawn) {
      PrintAgainst(style.empty() ? "(no style)" : style, set, (whole ? captured_whole : captured).at(style),
                   options.seed);
    }
  }
  for (const auto& [style, set] : drawn) {
    PrintAuc(style.empty() ? "(no style)" : style, set.clips, captured.at(style).clips, options);
  }
  PrintBody("synthesised", pooled);
  if (drawn.size() > 1) {
    std::printf("\n");
    PrintConfusion("asked style (rows) is given style (columns)",
                   ConfuseStyles(morphograph::StyleClassifier(Styled(captured)), Styled(drawn)));
  }
  TimeSampling(*graph, options);
  return SanityCheck(*graph, styles, all_whole.quality, options);
}

std::vector<MotionClip> Load(const std::vector<std::filesystem::path>& paths, int jobs) {
  std::vector<MotionClip> clips;
  const morphograph::DatasetManifest no_manifest;
  morphograph::Dataset dataset = morphograph::LoadDataset(paths, no_manifest, jobs);
  for (morphograph::LoadedClip& loaded : dataset.clips) {
    const bool at_rate = std::abs(loaded.clip.frame_rate_hz() - 30) < 0.03;
    clips.push_back(at_rate ? std::move(loaded.clip) : morphograph::Resample(loaded.clip, 30));
  }
  return clips;
}

// Time of the report that every synthesised clip gets, on captured motion of the same length.
void TimeEvaluation(const std::vector<MotionClip>& clips) {
  std::vector<double> times;
  int frames = 0;
  for (const MotionClip& clip : clips) {
    if (clip.frame_count() < 200) continue;
    const std::clock_t start = std::clock();  // processor time: the machine may be busy
    const auto evaluation = morphograph::EvaluateClip(clip);
    times.push_back(1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * 301 /
                    clip.frame_count());
    frames += static_cast<int>(evaluation.contact_distance_m.size());
  }
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  std::printf("EvaluateClip: median %.0f us for 301 frames (scaled from %zu clips, %d frames)\n",
              times[times.size() / 2], times.size(), frames);
}

bool Run(const Options& options) {
  const std::vector<MotionClip> whole = Load(options.data, options.jobs);
  const std::vector<MotionClip> trimmed = morphograph::WithoutEnds(whole, options.trim);
  std::printf(
      "captured: %zu clips; trimmed by %d frames at both ends %zu clips; pieces of %d frames at 30 fps\n",
      whole.size(), options.trim, trimmed.size(), options.piece);
  const Set all = Prepare(trimmed, options), all_whole = Prepare(whole, options);
  const std::map<std::string, Set> by_style = ByStyle(trimmed, options),
                                   by_style_whole = ByStyle(whole, options);
  PrintHeader();
  PrintAbsolute("captured, trimmed", all);
  PrintAbsolute("captured, whole", all_whole);
  for (const auto& [style, set] : by_style) PrintAbsolute(style.empty() ? "(no style)" : style, set);
  PrintBody("captured, whole", all_whole);
  TimeEvaluation(whole);
  if (by_style.size() > 1) {
    PrintConfusion("captured styles told by classifiers that have not seen them (5 parts)",
                   morphograph::CrossValidateStyles(Styled(by_style)));
  }
  if (!options.set.empty()) {
    std::printf("\nset / captured, trimmed\n");
    PrintHeader();
    const std::vector<MotionClip> clips = Load(options.set, options.jobs);
    const Set set = Prepare(clips, options);
    PrintAgainst("set / all", set, all, options.seed);
    for (const auto& [style, of_style] : ByStyle(clips, options)) {
      if (!style.empty() && by_style.count(style))
        PrintAgainst(style, of_style, by_style.at(style), options.seed);
    }
    PrintBody("set", set);
  }
  if (!options.model.empty()) {
    return JudgeModel(all, by_style, all_whole, by_style_whole, options);
  }
  if (options.set.empty() && options.model.empty()) SelfCheck(trimmed, all, by_style, options);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Motion quality against captured clips");
  Options options;
  app.add_option("--data", options.data, "captured BVH files and folders")->required();
  app.add_option("--model", options.model, "model to draw from");
  app.add_option("--set", options.set, "BVH files and folders to compare with the captured ones");
  app.add_option("--clips", options.clips, "clips to draw of each style")->check(CLI::Range(1, 100000));
  app.add_option("--duration", options.duration_s, "seconds of each drawn clip")
      ->check(CLI::Range(1.0, 600.0));
  app.add_option("--sanity", options.sanity, "clips to check for what no body can do")
      ->check(CLI::Range(0, 1000000));
  app.add_option("--trim", options.trim, "frames at 30 fps to cut off both ends of captured clips")
      ->check(CLI::Range(0, 10000));
  app.add_option("--piece", options.piece, "frames of the pieces that are measured")
      ->check(CLI::Range(15, 100000));
  app.add_option("--auc", options.auc, "halvings of the captured clips for a forest's AUC and its floor; 0: none")
      ->check(CLI::Range(0, 1000));
  app.add_option("--jobs", options.jobs, "threads to read with")->check(CLI::Range(1, 256));
  app.add_option("--seed", options.seed, "of the first clip and of all random halves");
  CLI11_PARSE(app, argc, argv);
  try {
    return Run(options) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "quality_benchmark: %s\n", error.what());
    return 1;
  }
}
