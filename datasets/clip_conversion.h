#pragma once

#include <map>
#include <optional>
#include <string>

#include "datasets/bvh_document.h"
#include "datasets/motion_clip.h"

namespace morphograph {

/// Overrides of what is otherwise detected (a dataset manifest fills these).
struct ClipImportOptions {
  std::optional<double> metres_per_unit = {};  // else detected from the body's size
  std::optional<UpAxis> up_axis = {};          // else detected from the pose
  std::map<std::string, std::string> roles = {};  // role name -> joint name
  bool drop_leading_rest = true;  // leading T-pose and all-zero rows
};

/// What the import found out and did.
struct ClipImportReport {
  int dropped_frames = 0;       // leading rest rows
  double metres_per_unit = 1;
  UpAxis up_axis = UpAxis::kY;
  std::string note;             // anything a user should know, else empty
};

/// Turns a BVH document into a clip in metres, Y up, with joint roles.
///
/// Position channels replace the joint's OFFSET. Motion of joints above the hips is folded into the hips'.
/// A bone whose position channels vary keeps its median offset, and the report says so.
/// @throws DatasetError when the document has no frame or no usable root, or a frame time outside of 0.001 to 1 s.
MotionClip ImportClip(const BvhDocument& document, const ClipImportOptions& options = {},
                      ClipImportReport* report = nullptr);

struct ClipExportOptions {
  bool source_channels = false;          // the source's own channel layout, else 6 on the root and 3 elsewhere
  std::optional<double> metres_per_unit = {};  // unit of the written file; the source's when empty
};

/// Turns a clip into a BVH document (CONTRACT.md, first paragraph: portable form). Euler angles are chosen
/// continuous from frame to frame.
BvhDocument ExportClip(const MotionClip& clip, const ClipExportOptions& options = {});

}  // namespace morphograph
