#include "datasets/gait_curves.h"

#include <boost/math/constants/constants.hpp>
#include <cmath>

namespace morphograph {

double FourierCurve::AtRad(double phase, double amplitude) const {
  using boost::math::double_constants::degree;
  using boost::math::double_constants::two_pi;
  double departure_deg = 0;
  for (size_t h = 0; h < harmonics_deg.size(); ++h) {
    const double angle = two_pi * static_cast<double>(h + 1) * phase;
    departure_deg += harmonics_deg[h][0] * std::cos(angle) + harmonics_deg[h][1] * std::sin(angle);
  }
  return (mean_deg + amplitude * departure_deg) * degree;
}

namespace gait_curves {

using Harmonics = std::array<std::array<double, 2>, 5>;

const FourierCurve kHipFlexion = {
    12.99, Harmonics{{{20.56, -3.24}, {-2.66, -1.77}, {-0.45, 0.83}, {-0.37, 0.18}, {0, 0}}}};
const FourierCurve kKneeFlexion = {
    22.66, Harmonics{{{-1.36, -20.14}, {-14.58, 6.07}, {-1.30, 4.12}, {-0.36, 0.71}, {-0.20, 0.32}}}};
const FourierCurve kAnkleDorsiflexion = {
    0.03, Harmonics{{{-0.83, 6.14}, {1.42, -7.84}, {-3.62, 0.58}, {1.89, -0.28}, {-0.07, -0.85}}}};
const FourierCurve kPelvisRotation = {0, Harmonics{{{4.6, 0.6}, {0, 0}, {0.4, 0}, {0, 0}, {0, 0}}}};
const FourierCurve kPelvisObliquity = {0, Harmonics{{{2.2, 2.9}, {0, 0}, {-0.5, 0.6}, {0, 0}, {0, 0}}}};
const FourierCurve kPelvisTilt = {2.0, Harmonics{{{0, 0}, {-0.3, 0.9}, {0, 0}, {0, 0}, {0, 0}}}};
const FourierCurve kChestRotation = {0, Harmonics{{{-4.0, 0.8}, {0, 0}, {0, 0}, {0, 0}, {0, 0}}}};
const FourierCurve kShoulderFlexion = {-4.0, Harmonics{{{-16.0, -1.5}, {0.8, 0.4}, {0, 0}, {0, 0}, {0, 0}}}};
const FourierCurve kElbowFlexion = {24.0, Harmonics{{{-9.0, -3.0}, {1.0, 0.5}, {0, 0}, {0, 0}, {0, 0}}}};

}  // namespace gait_curves
}  // namespace morphograph
