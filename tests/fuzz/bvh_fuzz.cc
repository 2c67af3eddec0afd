// BVH from strangers: whatever the bytes, reading answers with a document or a DatasetError, and what was read and
// imported survives being exported, written, read and imported again.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "datasets/bvh_reader.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "datasets/errors.h"
#include "datasets/forward_kinematics.h"

namespace {

using namespace morphograph;

void Require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "violated: %s\n", what);
  std::abort();
}

void CheckText(const BvhDocument& document) {
  BvhWriteOptions options;
  options.decimals = 9;
  const BvhDocument again = ParseBvh(WriteBvh(document, options), "again");
  Require(again.nodes.size() == document.nodes.size(), "same joints");
  for (std::size_t i = 0; i < again.nodes.size(); ++i) {
    Require(again.nodes[i].name == document.nodes[i].name, "same names");
    Require(again.nodes[i].channels == document.nodes[i].channels, "same channels");
    Require(again.nodes[i].parent == document.nodes[i].parent, "same parents");
  }
  Require(again.frame_time_s == document.frame_time_s, "same frame time");
  Require(again.values.cols() == document.values.cols(), "same frames");
  if (document.values.size() == 0) return;
  const double error = ((again.values - document.values).array().abs() -
                        1e-15 * document.values.array().abs()).maxCoeff();
  Require(error < 1e-8, "same values");
}

void CheckClip(const BvhDocument& document) {
  ClipImportReport report;
  const MotionClip clip = ImportClip(document, ClipImportOptions(), &report);
  ClipImportOptions same;
  same.metres_per_unit = report.metres_per_unit;
  same.up_axis = report.up_axis;
  same.drop_leading_rest = false;
  ClipExportOptions source_form;
  source_form.source_channels = true;
  (void)WriteBvh(ExportClip(clip, source_form));
  const MotionClip again = ImportClip(ExportClip(clip), same);
  Require(again.frame_count() == clip.frame_count(), "same number of frames");
  WorldPose one, other;
  for (int f = 0; f < clip.frame_count(); ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &one);
    ForwardKinematics(again.skeleton(), again.rotations(f), again.root_positions().col(f), &other);
    const double size = 1 + one.positions.cwiseAbs().maxCoeff();
    Require((one.positions - other.positions).cwiseAbs().maxCoeff() < 1e-6 * size, "same poses");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  BvhLimits limits;
  limits.max_joint_frames = 1'000'000;  // what an input may cost, so that there is time for many
  try {
    const BvhDocument document = ParseBvh(text, "fuzz", limits);
    CheckText(document);
    CheckClip(document);
  } catch (const DatasetError&) {
  }
  return 0;
}
