#include "primitives/time_warp.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

// (e^x - 1) / x = integral of e^(x s) over s in [0, 1].
double ExpIntegral(double x) { return std::abs(x) < 1e-12 ? 1.0 + 0.5 * x : std::expm1(x) / x; }

// Integral of s e^(x s) over s in [0, 1]: (e^x (x - 1) + 1) / x^2, by its series where that would cancel.
double FirstMoment(double x) {
  if (std::abs(x) > 0.5) return (std::exp(x) * (x - 1.0) + 1.0) / (x * x);
  double term = 1.0, sum = 0.5;
  for (int n = 1; n <= 13; ++n) {
    term *= x / n;
    sum += term / (n + 2);
  }
  return sum;
}

// Where a phase lies between the knots: interval and fraction of it.
struct KnotPosition {
  int interval = 0;
  double fraction = 0;
};

KnotPosition Locate(double phase, int knots) {
  const double scaled = phase * (knots - 1);
  const int interval = std::clamp(static_cast<int>(scaled), 0, knots - 2);
  return {interval, scaled - interval};
}

// Integral of the unnormalised slope over all intervals before `at` and a part of its own, with its gradient by
// the log slopes.
struct Integral {
  double value = 0;
  Eigen::VectorXd gradient;
};

void AddInterval(const Eigen::VectorXd& log_slopes, const KnotPosition& at, Integral* sum) {
  // Over a part f of the interval, log slope a + x s with x = (b - a) f: h f e^a ExpIntegral(x); d/db weighs by s f.
  const int k = at.interval;
  const double f = at.fraction;
  const double x = (log_slopes[k + 1] - log_slopes[k]) * f;
  const double scale = std::exp(log_slopes[k]) * f / static_cast<double>(log_slopes.size() - 1);
  const double whole = scale * ExpIntegral(x);
  const double by_upper = scale * f * FirstMoment(x);
  sum->value += whole;
  sum->gradient[k] += whole - by_upper;
  sum->gradient[k + 1] += by_upper;
}

struct FitProblem {
  std::vector<double> reference_phase, test_phase;
  double regularisation = 0;
  Eigen::VectorXd knot_weights;  // trapezoid rule, sum 1
};

// Value, half gradient and Gauss-Newton matrix of the fit at `log_slopes`.
double Linearise(const FitProblem& problem, const Eigen::VectorXd& log_slopes, Eigen::VectorXd* gradient,
                 Eigen::MatrixXd* hessian) {
  const int knots = static_cast<int>(log_slopes.size());
  // Integrals up to every knot, shared by all the cells.
  std::vector<Integral> at_knots(static_cast<std::size_t>(knots));
  at_knots[0].gradient = Eigen::VectorXd::Zero(knots);
  for (int k = 1; k < knots; ++k) {
    at_knots[k] = at_knots[k - 1];
    AddInterval(log_slopes, {k - 1, 1.0}, &at_knots[k]);
  }
  const Integral& total = at_knots.back();

  gradient->setZero(knots);
  hessian->setZero(knots, knots);
  const double cell_weight = 1.0 / static_cast<double>(problem.reference_phase.size());
  double value = 0;
  Integral integral;
  Eigen::VectorXd row(knots);
  for (std::size_t i = 0; i < problem.reference_phase.size(); ++i) {
    const KnotPosition at = Locate(problem.reference_phase[i], knots);
    integral = at_knots[at.interval];
    AddInterval(log_slopes, at, &integral);
    const double warped = integral.value / total.value;
    const double residual = warped - problem.test_phase[i];
    row = (integral.gradient - warped * total.gradient) / total.value;
    value += cell_weight * residual * residual;
    *gradient += (cell_weight * residual) * row;
    *hessian += cell_weight * row * row.transpose();
  }
  const Eigen::VectorXd pull = problem.regularisation * problem.knot_weights;
  value += (pull.array() * log_slopes.array().square()).sum();
  *gradient += (pull.array() * log_slopes.array()).matrix();
  hessian->diagonal() += pull;
  return value;
}

}  // namespace

bool CanWarp(int reference_frames, int test_frames, const TimeWarpOptions& options) {
  if (reference_frames < 1 || test_frames < 1 || options.max_slope < 0) return false;
  // The shorter segment has `shorter` frames on which a run may stand and shorter - 1 diagonal steps between them.
  const long long shorter = std::min(reference_frames, test_frames);
  const long long longer = std::max(reference_frames, test_frames);
  return longer - 1 <= (shorter - 1) + shorter * options.max_slope;
}

WarpPath DynamicTimeWarp(const Eigen::MatrixXd& cost, const TimeWarpOptions& options) {
  const int rows = static_cast<int>(cost.rows()), columns = static_cast<int>(cost.cols());
  if (options.max_slope < 0)
    throw std::invalid_argument("DynamicTimeWarp: max_slope is " + std::to_string(options.max_slope) + "; must be >= 0");
  if (rows == 0 || columns == 0) throw std::invalid_argument("DynamicTimeWarp: the cost matrix is empty");
  if (!cost.allFinite()) throw std::invalid_argument("DynamicTimeWarp: the cost matrix holds values that are not finite");
  if (!CanWarp(rows, columns, options))
    throw std::invalid_argument("DynamicTimeWarp: " + std::to_string(rows) + " reference frames and " +
                                std::to_string(columns) + " test frames cannot be matched with at most " +
                                std::to_string(options.max_slope) + " steps in a row in one direction");

  // States of a cell: 0 = reached diagonally (or the start), 1..s = after that many vertical steps in a row (reference
  // moves on), s+1..2s = after horizontal ones (test moves on). `from` holds the state of the cell stepped from.
  // A limit beyond the matrix limits nothing, so the number of states stays bounded by its size.
  const int s = std::min(options.max_slope, std::max(rows, columns));
  const int states = 2 * s + 1;
  const double infinity = std::numeric_limits<double>::infinity();
  const std::size_t cells = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  std::vector<double> total(cells * states, infinity);
  std::vector<int> from(cells * states, -1);
  const auto at = [&](int i, int j) { return (static_cast<std::size_t>(i) * columns + j) * states; };
  // The cheapest state in [first, last) of a cell, the lowest of equals.
  const auto best_state = [&](std::size_t cell, int first, int last) {
    return static_cast<int>(std::min_element(total.begin() + cell + first, total.begin() + cell + last) - total.begin() - cell);
  };
  total[at(0, 0)] = cost(0, 0);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const std::size_t here = at(i, j);
      const auto step = [&](int state, std::size_t cell, int previous) {
        total[here + state] = total[cell + previous] + cost(i, j);
        from[here + state] = previous;
      };
      if (i > 0 && j > 0) step(0, at(i - 1, j - 1), best_state(at(i - 1, j - 1), 0, states));
      if (s == 0) continue;
      if (i > 0) {  // a first vertical step follows a diagonal or a horizontal one
        const std::size_t above = at(i - 1, j);
        const int horizontal = best_state(above, s + 1, states);
        step(1, above, total[above] <= total[above + horizontal] ? 0 : horizontal);
        for (int run = 2; run <= s; ++run) step(run, above, run - 1);
      }
      if (j > 0) {
        const std::size_t left = at(i, j - 1);
        step(s + 1, left, best_state(left, 0, s + 1));
        for (int run = 2; run <= s; ++run) step(s + run, left, s + run - 1);
      }
    }
  }

  WarpPath path;
  int i = rows - 1, j = columns - 1;
  int state = best_state(at(i, j), 0, states);
  path.cost = total[at(i, j) + state];
  while (true) {
    path.cells.push_back({i, j});
    if (i == 0 && j == 0) break;
    const int previous = from[at(i, j) + state];
    if (state == 0) {
      --i;
      --j;
    } else if (state <= s) {
      --i;
    } else {
      --j;
    }
    state = previous;
  }
  std::reverse(path.cells.begin(), path.cells.end());
  return path;
}

int ChooseReference(const Eigen::MatrixXd& pairwise_distances) {
  if (pairwise_distances.rows() == 0 || pairwise_distances.rows() != pairwise_distances.cols())
    throw std::invalid_argument("ChooseReference: needs a square matrix of distances, got " +
                                std::to_string(pairwise_distances.rows()) + " x " + std::to_string(pairwise_distances.cols()));
  Eigen::Index best = 0;
  pairwise_distances.rowwise().sum().minCoeff(&best);
  return static_cast<int>(best);
}

TimeWarp::TimeWarp(const Eigen::VectorXd& log_slopes) {
  const Eigen::Index knots = log_slopes.size();
  if (knots < 2) throw std::invalid_argument("TimeWarp: needs at least 2 knots, got " + std::to_string(knots));
  if (!log_slopes.allFinite()) throw std::invalid_argument("TimeWarp: log slopes must be finite");
  // Measured from the largest, so that no exponential overflows.
  log_slopes_ = log_slopes.array() - log_slopes.maxCoeff();
  at_knots_.setZero(knots);
  for (Eigen::Index k = 0; k + 1 < knots; ++k) {
    at_knots_[k + 1] = at_knots_[k] + std::exp(log_slopes_[k]) * ExpIntegral(log_slopes_[k + 1] - log_slopes_[k]) /
                                          static_cast<double>(knots - 1);
  }
  const double total = at_knots_[knots - 1];
  at_knots_ /= total;
  log_slopes_.array() -= std::log(total);
}

double TimeWarp::operator()(double canonical_phase) const {
  if (canonical_phase <= 0) return canonical_phase * std::exp(log_slopes_[0]);
  if (canonical_phase >= 1) return 1 + (canonical_phase - 1) * std::exp(log_slopes_[knots() - 1]);
  const KnotPosition at = Locate(canonical_phase, knots());
  const double rise = log_slopes_[at.interval + 1] - log_slopes_[at.interval];
  return at_knots_[at.interval] + std::exp(log_slopes_[at.interval]) * at.fraction / (knots() - 1) * ExpIntegral(rise * at.fraction);
}

double TimeWarp::Slope(double canonical_phase) const {
  const KnotPosition at = Locate(std::clamp(canonical_phase, 0.0, 1.0), knots());
  return std::exp(log_slopes_[at.interval] + at.fraction * (log_slopes_[at.interval + 1] - log_slopes_[at.interval]));
}

double TimeWarp::Inverse(double source_phase) const {
  if (source_phase <= 0) return source_phase * std::exp(-log_slopes_[0]);
  if (source_phase >= 1) return 1 + (source_phase - 1) * std::exp(-log_slopes_[knots() - 1]);
  const auto above = std::upper_bound(at_knots_.begin(), at_knots_.end(), source_phase);
  const int interval = std::clamp(static_cast<int>(above - at_knots_.begin()) - 1, 0, knots() - 2);
  // e^a h (e^(rise f) - 1) / rise = y  =>  f = log(1 + rise y e^-a / h) / rise.
  const double linear = (source_phase - at_knots_[interval]) * std::exp(-log_slopes_[interval]) * (knots() - 1);
  const double x = (log_slopes_[interval + 1] - log_slopes_[interval]) * linear;
  const double fraction = std::abs(x) < 1e-12 ? linear : linear * (std::log1p(x) / x);
  return (interval + fraction) / (knots() - 1);
}

Eigen::VectorXd TimeWarp::Gradient(double canonical_phase) const {
  const int last = knots() - 1;
  const auto up_to = [&](const KnotPosition& at) {
    Integral integral{0, Eigen::VectorXd::Zero(knots())};
    for (int k = 0; k < at.interval; ++k) AddInterval(log_slopes_, {k, 1.0}, &integral);
    AddInterval(log_slopes_, at, &integral);
    return integral;
  };
  const Integral total = up_to({last - 1, 1.0});
  if (canonical_phase > 0 && canonical_phase < 1) {
    const Integral integral = up_to(Locate(canonical_phase, knots()));
    return (integral.gradient - integral.value / total.value * total.gradient) / total.value;
  }
  // Beyond the key frames the border's slope, e^s / total, goes on.
  const int border = canonical_phase <= 0 ? 0 : last;
  const double beyond = canonical_phase <= 0 ? canonical_phase : canonical_phase - 1;
  const double slope = std::exp(log_slopes_[border]) / total.value;
  Eigen::VectorXd gradient = -slope * beyond / total.value * total.gradient;
  gradient[border] += slope * beyond;
  return gradient;
}

TimeWarp TimeWarp::Fit(const WarpPath& path, int reference_frames, int test_frames, int knots, double regularisation) {
  if (knots < 2) throw std::invalid_argument("TimeWarp::Fit: needs at least 2 knots, got " + std::to_string(knots));
  if (!(regularisation > 0)) throw std::invalid_argument("TimeWarp::Fit: regularisation must be > 0");
  if (reference_frames < 2 || test_frames < 2)
    throw std::invalid_argument("TimeWarp::Fit: segments need at least 2 frames, got " + std::to_string(reference_frames) +
                                " and " + std::to_string(test_frames));
  if (path.cells.empty()) throw std::invalid_argument("TimeWarp::Fit: the path is empty");
  FitProblem problem;
  for (const WarpCell& cell : path.cells) {
    if (cell.reference < 0 || cell.reference >= reference_frames || cell.test < 0 || cell.test >= test_frames)
      throw std::invalid_argument("TimeWarp::Fit: cell (" + std::to_string(cell.reference) + ", " + std::to_string(cell.test) +
                                  ") lies outside " + std::to_string(reference_frames) + " x " + std::to_string(test_frames) +
                                  " frames");
    problem.reference_phase.push_back(cell.reference / (reference_frames - 1.0));
    problem.test_phase.push_back(cell.test / (test_frames - 1.0));
  }
  problem.regularisation = regularisation;
  problem.knot_weights = Eigen::VectorXd::Constant(knots, 1.0 / (knots - 1));
  problem.knot_weights[0] = problem.knot_weights[knots - 1] = 0.5 / (knots - 1);

  Eigen::VectorXd log_slopes = Eigen::VectorXd::Zero(knots), gradient, next_gradient;
  Eigen::MatrixXd hessian, next_hessian;
  double value = Linearise(problem, log_slopes, &gradient, &hessian);
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Eigen::LLT<Eigen::MatrixXd> llt(hessian);  // positive definite by the regularisation
    if (llt.info() != Eigen::Success) break;
    Eigen::VectorXd step = -llt.solve(gradient);
    const double length = step.norm();
    bool better = false;
    for (int halving = 0; halving < 20 && !better; ++halving, step *= 0.5) {
      const Eigen::VectorXd candidate = log_slopes + step;
      const double next = Linearise(problem, candidate, &next_gradient, &next_hessian);
      if (next <= value) {
        log_slopes = candidate;
        value = next;
        gradient.swap(next_gradient);
        hessian.swap(next_hessian);
        better = true;
      }
    }
    if (!better || length < 1e-6) break;  // of log slope: far below what a frame can tell
  }
  return TimeWarp(log_slopes);
}

}  // namespace morphograph
