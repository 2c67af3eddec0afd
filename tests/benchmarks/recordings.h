#pragma once

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "datasets/dataset_loader.h"
#include "datasets/resample.h"
#include "datasets/retarget.h"

namespace morphograph {

/// A captured clip as it is, and on the skeleton that a base is of.
struct Recording {
  MotionClip own;
  MotionClip common;
  std::string group;  // its style, or the subject
};

/// Recordings of folders below `data`, files by name within each folder; `group_of_folder` groups them by folder and not by style.
inline std::vector<Recording> LoadRecordings(const std::filesystem::path& data, const std::vector<std::string>& folders, double frame_rate_hz,
                                             bool group_of_folder) {
  std::vector<Recording> recordings;
  for (const std::string& folder : folders) {
    for (LoadedClip& loaded : LoadDataset({data / folder}, DatasetManifest(), 2).clips) {
      Recording recording;
      recording.own = Resample(loaded.clip, frame_rate_hz);
      if (recordings.empty()) recording.common = recording.own;
      const auto& common = recordings.empty() ? recording.own.shared_skeleton() : recordings.front().own.shared_skeleton();
      recording.common = recording.own.shared_skeleton() == common ? recording.own : Retarget(recording.own, common);
      recording.group = group_of_folder ? folder : loaded.clip.style;
      recordings.push_back(std::move(recording));
    }
  }
  return recordings;
}

/// A base and what it has not seen.
struct Split {
  std::string name;
  std::vector<MotionClip> base;    // on the common skeleton
  std::vector<Recording> unseen;
};

/// Which of the clips that a rule picks: to tune on, or to test on. Neither is ever in the base.
enum class Purpose { kTune, kTest };

/// Of all clips in order, every `step`-th from the (step/2 + 1)-th is to test on, from the 1st to tune on; the base is the rest.
inline Split ClipOut(const std::vector<Recording>& all, std::size_t step, Purpose purpose) {
  Split split{"clip out", {}, {}};
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool tests = i % step == step / 2, tunes = i % step == 0;
    if (purpose == Purpose::kTest ? tests : tunes) split.unseen.push_back(all[i]);
    else if (!tests && !tunes) split.base.push_back(all[i].common);
  }
  return split;
}

/// The same clips to test or tune on, each with a base of all others: small sets lose too much otherwise.
inline std::vector<Split> EachClipOut(const std::vector<Recording>& all, std::size_t step, Purpose purpose) {
  std::vector<Split> splits;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i % step != (purpose == Purpose::kTest ? step / 2 : 0)) continue;
    Split split{"clip " + std::to_string(i) + " out", {}, {all[i]}};
    for (std::size_t j = 0; j < all.size(); ++j) {
      if (j != i) split.base.push_back(all[j].common);
    }
    splits.push_back(std::move(split));
  }
  return splits;
}

/// The clips of known styles: every 30th.
inline Split KnownStyle(const std::vector<Recording>& all, Purpose purpose) { return ClipOut(all, 30, purpose); }

/// Unseen group (style or subject): the base is all other groups; of the group's clips in order every `step`-th from the (step/2 + 1)-th is to test on, from the
/// 1st to tune on.
inline std::vector<Split> UnseenGroups(const std::vector<Recording>& all, std::size_t step, Purpose purpose) {
  std::vector<std::string> groups;
  for (const Recording& recording : all) {
    if (std::find(groups.begin(), groups.end(), recording.group) == groups.end()) groups.push_back(recording.group);
  }
  std::vector<Split> splits;
  for (const std::string& group : groups) {
    Split split{"without " + group, {}, {}};
    std::size_t n = 0;
    for (const Recording& recording : all) {
      if (recording.group != group) split.base.push_back(recording.common);
      else if (n++ % step == (purpose == Purpose::kTest ? step / 2 : 0)) split.unseen.push_back(recording);
    }
    splits.push_back(std::move(split));
  }
  return splits;
}

}  // namespace morphograph
