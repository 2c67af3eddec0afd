#pragma once

#include <array>

namespace morphograph {

/// A periodic curve over the gait cycle: mean + sum of a_h cos(2 pi h phase) + b_h sin(2 pi h phase).
struct FourierCurve {
  double mean_deg = 0;
  std::array<std::array<double, 2>, 5> harmonics_deg = {};  // {a_h, b_h}

  /// Angle in radians. @param phase  in cycles, 0 at the strike of the side the curve belongs to.
  /// @param amplitude  scales the departure from the mean.
  double AtRad(double phase, double amplitude = 1) const;
};

/// Typical joint angles of adults who walk at about 1.3 m/s. Shapes follow what clinical gait analysis reports as normal (Perry &
/// Burnfield, "Gait Analysis", chapters 3-6; Winter, "Biomechanics and Motor Control of Human Movement", appendix A); the
/// coefficients are our own fits through a dozen typical points of each curve, within 1.3 degrees of them.
/// Phase 0 is the strike of the own foot, toe-off is near `kToeOffPhase`.
namespace gait_curves {

inline constexpr double kToeOffPhase = 0.62;
inline constexpr double kNormalStatureM = 1.75;  // of the fitted curves
inline constexpr double kNormalStepM = 0.70;
inline constexpr double kNormalSpeedMS = 1.3;

extern const FourierCurve kHipFlexion;
extern const FourierCurve kKneeFlexion;
extern const FourierCurve kAnkleDorsiflexion;
/// Odd harmonics only, so that the other side half a cycle later is the mirror image.
extern const FourierCurve kPelvisRotation;   // own side forward, about the vertical
extern const FourierCurve kPelvisObliquity;  // own side up
extern const FourierCurve kPelvisTilt;       // forward; both sides alike, even harmonics only
extern const FourierCurve kChestRotation;    // own side forward, relative to the path
extern const FourierCurve kShoulderFlexion;
extern const FourierCurve kElbowFlexion;

}  // namespace gait_curves
}  // namespace morphograph
