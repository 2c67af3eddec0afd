#pragma once

namespace morphograph {

/// Parts of the synthesis to leave out, so that a study can tell what each of them is worth. No request can set them.
struct SynthesisVariant {
  bool cross_fade = true;  // false: one step gives way to the next at the key frame, at once; increments of the root are kept
  bool foot_lock = true;   // false: feet stay where the steps put them
};

}  // namespace morphograph
