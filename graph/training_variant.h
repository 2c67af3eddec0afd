#pragma once

namespace morphograph {

/// Parts of the method to leave out when a model is learned, so that a study can tell what each of them is worth. As it stands,
/// nothing is left out.
struct TrainingVariant {
  enum class Transition {
    kStationary,   // linear part and process, noise matched to keep the captured marginal (METHODS section 3)
    kProcessOnly,  // Du 3.5: the RBF process alone, its residuals as they are
    kNone,         // every step drawn from its mixture, whatever came before
  };
  bool styles = true;        // false: one model pooled over all styles
  bool timing = true;        // false: every step has its class's mean duration and warp
  bool margins = true;       // false: samples outside of the step have next to no say in the reduction
  bool weighted = true;      // false: plain PCA, every pose channel counts alike in its own unit
  bool euler = false;        // true: Euler angles in the recording's channel order in place of log maps (Du Eq. 3.8)
  bool manner = true;        // false: nothing of a walk stays over its steps (see MannerModel)
  Transition transition = Transition::kStationary;
};

}  // namespace morphograph
