#include "graph/training_steps.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/forward_kinematics.h"
#include "datasets/parallel_for.h"
#include "datasets/quantile.h"
#include "primitives/decomposition.h"
#include "primitives/keyframe_detector.h"

namespace morphograph {
namespace {

// A joint that stays within this of its first rotation in every clip is not modelled (0.06 degrees).
constexpr double kStill_rad = 1e-3;

// A rolling foot turns the ball joint a little under the height at which it stands; more than this is a fault of the recording.
constexpr double kBallGive_m = 0.009;
// Of the clips' lowest points: lower than in all but one of twenty clips is a fault of the recording too.
constexpr double kLowestPart = 0.05;

}  // namespace

std::vector<TrainingStep> FindSteps(const std::vector<PreparedClip>& clips, int jobs, const std::string& action,
                                    const KeyframeFinder& find_keyframes) {
  std::map<std::string, KeyframeFinder> finders;  // by action
  for (const PreparedClip& clip : clips) {
    const std::string& shown = clip.ActionOr(action);
    KeyframeFinder& find = finders[shown];
    if (find) continue;
    if (find_keyframes && clip.other_action.empty()) {
      find = find_keyframes;
    } else {
      find = [options = KeyframeOptionsFor(shown)](const MotionClip& of) { return DetectKeyframes(of, options); };
    }
  }
  std::vector<std::vector<Segment>> per_clip(clips.size());
  ParallelFor(jobs, static_cast<int>(clips.size()), [&](int c) {
    try {
      const std::string& shown = clips[c].ActionOr(action);
      per_clip[c] = Decompose(clips[c].clip, c, finders.at(shown)(clips[c].clip), {.action = shown});
    } catch (const std::invalid_argument& unfit) {
      throw DatasetError(clips[c].clip.name, ReasonOf(unfit));
    }
  });
  std::vector<TrainingStep> steps;
  for (const std::vector<Segment>& segments : per_clip) {
    const int first = static_cast<int>(steps.size());
    for (const Segment& segment : segments) {
      steps.push_back({segment.clip,
                       {segment.start_frame, segment.end_frame},
                       segment.primitive,
                       segment.start,
                       segment.end,
                       segment.previous < 0 ? -1 : first + segment.previous,
                       segment.steady,
                       segment.slow_step});
    }
  }
  return steps;
}

std::string NameInNotes(const std::string& primitive, const std::string& style, const std::string& other_action) {
  if (style.empty() && other_action.empty()) return primitive;
  return primitive + " (" + style + (style.empty() || other_action.empty() ? "" : ", ") + other_action + ")";
}

std::string WalkingNameOf(const TrainingStep& step, const std::string& action) {
  return step.slow_step ? step.primitive.substr(0, step.primitive.find('_') + 1) + action : step.primitive;
}

std::vector<std::string> SettleSlowSteps(const std::vector<PreparedClip>& clips, const std::string& action, int fewest,
                                         std::vector<TrainingStep>* steps) {
  struct Found {
    int out_of_standing = 0, slow = 0;
  };
  std::map<std::tuple<std::string, std::string, std::string>, Found> found;
  const auto key = [&](const TrainingStep& step) {
    return std::tuple{clips[step.clip].other_action, clips[step.clip].clip.style, step.primitive};
  };
  for (const TrainingStep& step : *steps) {
    if (step.slow_step) {
      ++found[key(step)].slow;
    } else if (step.steady) {
      ++found[key(step)].out_of_standing;
    }
  }
  std::vector<std::string> notes;
  for (const auto& [kind, count] : found) {
    const auto& [other_action, style, name] = kind;
    if (count.slow == 0 || count.slow >= fewest || count.out_of_standing >= fewest) continue;
    notes.push_back(NameInNotes(name, style, other_action) + ": only " + std::to_string(count.slow) +
                    " examples that are slow steps of a walk, at least " + std::to_string(fewest) + " are needed; left out");
  }
  for (TrainingStep& step : *steps) {
    if (!step.slow_step) continue;
    const Found& all = found[key(step)];
    if (all.out_of_standing < fewest && all.slow >= fewest) continue;
    const bool left = step.primitive.starts_with("left");
    step.primitive = WalkingNameOf(step, clips[step.clip].ActionOr(action));
    const KeyframeLabel landed = left ? KeyframeLabel::kLeftStance : KeyframeLabel::kRightStance;
    const KeyframeLabel stood = left ? KeyframeLabel::kRightStance : KeyframeLabel::kLeftStance;
    step.start = stood;
    step.end = landed;
    step.steady = step.slow_step = false;
  }
  // What is left of the other kind where slow steps make the class is of no use to it.
  for (TrainingStep& step : *steps) {
    if (step.slow_step || !step.steady) continue;
    const auto same = found.find(key(step));
    if (same != found.end() && same->second.out_of_standing < fewest && same->second.slow >= fewest) step.steady = false;
  }
  return notes;
}

std::vector<StepClass> GroupSteps(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps) {
  std::map<std::tuple<std::string, std::string, std::string>, std::vector<int>> groups;
  for (size_t i = 0; i < steps.size(); ++i) {
    const PreparedClip& clip = clips[steps[i].clip];
    groups[{clip.other_action, clip.clip.style, steps[i].primitive}].push_back(static_cast<int>(i));
  }
  std::vector<StepClass> classes;
  for (auto& [kind, members] : groups) {
    classes.push_back({std::get<0>(kind), std::get<1>(kind), std::get<2>(kind), std::move(members)});
  }
  return classes;
}

std::vector<int> FindActiveJoints(const std::vector<PreparedClip>& clips) {
  const Skeleton& skeleton = clips.front().clip.skeleton();
  std::vector<int> active = {skeleton.moving_root()};
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    if (j == skeleton.moving_root() || !skeleton.IsBody(j)) continue;
    const Eigen::Quaterniond& first = clips.front().clip.rotation(0, j);
    const bool moves = std::any_of(clips.begin(), clips.end(), [&](const PreparedClip& prepared) {
      for (int f = 0; f < prepared.clip.frame_count(); ++f) {
        if (first.angularDistance(prepared.clip.rotation(f, j)) > kStill_rad) return true;
      }
      return false;
    });
    if (moves) active.push_back(j);
  }
  return active;
}

FeetGeometry MeasureFeet(const std::vector<const PreparedClip*>& clips) {
  FeetGeometry feet;
  for (int side = 0; side < 2; ++side) {
    const JointRole ankle_role = side == 0 ? JointRole::kLeftAnkle : JointRole::kRightAnkle;
    Eigen::Vector3d heel_sum = Eigen::Vector3d::Zero();
    int heel_count = 0;
    std::vector<double> heel_heights, ball_heights, heel_lowest, ball_lowest;
    for (const PreparedClip* prepared : clips) {
      const MotionClip& clip = prepared->clip;
      const int ankle = clip.skeleton().roles()[ankle_role];
      heel_lowest.push_back(prepared->contacts.heels[side].row(1).minCoeff());
      ball_lowest.push_back(prepared->contacts.balls[side].row(1).minCoeff());
      for (int f = 0; f < clip.frame_count(); ++f) {
        const bool heel = prepared->contacts.planted(2 * side, f) != 0;
        const bool ball = prepared->contacts.planted(2 * side + 1, f) != 0;
        if (!heel || !ball) continue;  // flat on the floor
        const WorldPose pose = ForwardKinematics(clip, f);
        heel_sum += pose.rotations[ankle].conjugate() * (prepared->contacts.heels[side].col(f) - pose.positions.col(ankle));
        ++heel_count;
        heel_heights.push_back(prepared->contacts.heels[side](1, f));
        ball_heights.push_back(prepared->contacts.balls[side](1, f));
      }
    }
    if (heel_count > 0) feet.heel_offset_m[side] = heel_sum / heel_count;
    // A foot that is never flat on the floor, as in runs on tiptoe, stands on its lowest point.
    feet.heel_height_m[side] = Median(heel_heights.empty() ? heel_lowest : heel_heights);
    feet.ball_height_m[side] = Median(ball_heights.empty() ? ball_lowest : ball_heights);
    feet.heel_lowest_m[side] = Quantile(heel_lowest, kLowestPart);
    feet.ball_lowest_m[side] = std::max(Quantile(ball_lowest, kLowestPart), feet.ball_height_m[side] - kBallGive_m);
  }
  return feet;
}

}  // namespace morphograph
