#pragma once

#include <string>
#include <vector>

#include "datasets/dataset_loader.h"
#include "graph/graph_builder.h"
#include "primitives/keyframe_labels.h"

namespace morphograph {

/// Labels of the clips of a set.
struct MatchedLabels {
  std::vector<std::vector<LabelledFrame>> frames;  // a list a clip, empty for most; frames of the clip as it was loaded
  std::vector<std::string> notes;                  // labels that no clip takes
};

/// Finds the clip that each list of labels is of: by file stem, or by the end of the path where several have the stem. Doubtful labels and
/// those outside of the clip's part in use are left out.
/// @param source  file of the labels, for messages.
/// @throws DatasetError when a name means several clips, or no label lies in any clip.
MatchedLabels MatchLabels(const LabelledClips& labels, const std::vector<LoadedClip>& clips, const std::string& source);

/// Finds key frames by their likeness to labelled ones (LearnedKeyframeDetector), for training.
/// @param clips, frames  alike in number; copied. @throws DatasetError when the examples teach nothing, or no walking key frame.
KeyframeFinder LearnKeyframes(const std::vector<MotionClip>& clips, const std::vector<std::vector<LabelledFrame>>& frames,
                              const std::string& source);

}  // namespace morphograph
