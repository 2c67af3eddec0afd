#include "datasets/augmentation.h"

#include <boost/math/constants/constants.hpp>
#include <cmath>
#include <stdexcept>

#include "datasets/bend.h"
#include "datasets/contact_detector.h"
#include "datasets/eased_stop.h"
#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/floor_leveling.h"
#include "datasets/mirror.h"
#include "datasets/parallel_for.h"

namespace morphograph {
namespace {

std::vector<AugmentedClip> CopiesOf(const MotionClip& clip, const AugmentationOptions& options) {
  if (clip.frame_count() < 2 || !clip.skeleton().roles().Missing(LocomotionRoles()).empty()) return {{clip, false}};
  std::vector<AugmentedClip> copies = {{LevelFloor(clip), false}};
  if (const std::optional<int> hold = FindHold(copies.front().clip)) {
    copies.push_back({EasedStop(copies.front().clip, *hold), true});
  }
  if (options.mirror) {
    const size_t unmirrored = copies.size();
    for (size_t i = 0; i < unmirrored; ++i) copies.push_back({Mirrored(copies[i].clip), true});
  }
  const size_t unbent = copies.size();
  for (size_t i = 0; i < unbent; ++i) {
    const MotionClip straight = copies[i].clip;
    const ContactTrack contacts = DetectContacts(straight);
    for (const double bend : options.bends_rad) {
      MotionClip bent = Bent(straight, contacts, {bend, options.bend_ease_s});
      const int degrees = static_cast<int>(std::lround(std::abs(bend) / boost::math::double_constants::degree));
      bent.name += "_" + std::to_string(degrees);
      copies.push_back({std::move(bent), true});
    }
  }
  return copies;
}

}  // namespace

AugmentationOptions AugmentationOf(const DatasetManifest& manifest) {
  AugmentationOptions options;
  options.mirror = manifest.mirror;
  if (manifest.bend) {
    for (const double degrees : {7.0, -7.0, 14.0, -14.0, 20.0, -20.0}) {
      options.bends_rad.push_back(degrees * boost::math::double_constants::degree);
    }
  }
  return options;
}

std::vector<AugmentedClip> Augment(const std::vector<MotionClip>& clips, const AugmentationOptions& options, int jobs) {
  std::vector<std::vector<AugmentedClip>> copies(clips.size());
  ParallelFor(jobs, static_cast<int>(clips.size()), [&](int i) { 
    try {
      copies[i] = CopiesOf(clips[i], options);
    } catch (const std::invalid_argument& unfit) {
      throw DatasetError(clips[i].name, ReasonOf(unfit));
    }
  });
  std::vector<AugmentedClip> all;
  for (std::vector<AugmentedClip>& of_clip : copies) {
    for (AugmentedClip& copy : of_clip) all.push_back(std::move(copy));
  }
  return all;
}

}  // namespace morphograph
