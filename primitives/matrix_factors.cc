#include "primitives/matrix_factors.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Jacobi>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace morphograph {
namespace {

constexpr int kMaxSweeps = 30;

using CountKept = std::function<Eigen::Index(const Eigen::VectorXd&)>;

// Makes the columns of `x` orthogonal, turning those of `v` with them. Columns that are rounding beside the longest one have
// no direction of their own and are left alone.
void OrthogonaliseColumns(Eigen::MatrixXd* x, Eigen::MatrixXd* v) {
  const Eigen::Index n = x->cols();
  const double tolerance = static_cast<double>(x->rows()) * std::numeric_limits<double>::epsilon();
  Eigen::VectorXd squares = x->colwise().squaredNorm();
  const double least = squares.size() > 0 ? squares.maxCoeff() * tolerance * tolerance : 0;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool is_turned = false;
    for (Eigen::Index p = 0; p + 1 < n; ++p) {
      for (Eigen::Index q = p + 1; q < n; ++q) {
        if (!(squares[p] > least && squares[q] > least)) continue;
        const double product = x->col(p).dot(x->col(q));
        if (!(std::abs(product) > tolerance * std::sqrt(squares[p] * squares[q]))) continue;
        Eigen::JacobiRotation<double> turn;
        turn.makeJacobi(squares[p], product, squares[q]);
        x->applyOnTheRight(p, q, turn);
        v->applyOnTheRight(p, q, turn);
        squares[p] = x->col(p).squaredNorm();
        squares[q] = x->col(q).squaredNorm();
        is_turned = true;
      }
    }
    if (!is_turned) return;
  }
  throw std::runtime_error("FactorSingular: the rotations do not converge");
}

// Of `scale` times the matrix.
SingularFactors FactorSquare(const Eigen::MatrixXd& square, double scale, const CountKept& count_kept) {
  Eigen::MatrixXd v = FactorSymmetric(square.transpose() * square).vectors.rowwise().reverse();
  Eigen::MatrixXd x = square * v;
  OrthogonaliseColumns(&x, &v);

  const Eigen::Index n = x.cols();
  const Eigen::VectorXd lengths = x.colwise().norm();
  std::vector<Eigen::Index> order(static_cast<size_t>(n));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return lengths[a] > lengths[b]; });
  const double rounding = static_cast<double>(x.rows()) * std::numeric_limits<double>::epsilon();
  SingularFactors out;
  out.values.resize(n);
  Eigen::Index rank = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    out.values[k] = lengths[order[static_cast<size_t>(k)]];
    if (out.values[k] > rounding * out.values[0]) rank = k + 1;
  }
  out.values *= scale;
  const Eigen::Index kept = count_kept ? std::min(rank, count_kept(out.values)) : rank;
  out.u.resize(x.rows(), kept);
  out.v.resize(n, kept);
  for (Eigen::Index k = 0; k < kept; ++k) {
    const Eigen::Index from = order[static_cast<size_t>(k)];
    out.u.col(k) = x.col(from) / lengths[from];
    out.v.col(k) = v.col(from);
  }
  return out;
}

}  // namespace

SymmetricFactors FactorSymmetric(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success) throw std::runtime_error("FactorSymmetric: the eigenvalues do not converge");
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SingularFactors FactorSingular(const Eigen::MatrixXd& matrix, const CountKept& count_kept) {
  if (matrix.rows() < matrix.cols()) {
    SingularFactors turned = FactorSingular(matrix.transpose(), count_kept);
    turned.u.swap(turned.v);
    return turned;
  }
  const Eigen::Index n = matrix.cols();
  if (n == 0) return {Eigen::VectorXd(0), Eigen::MatrixXd(matrix.rows(), 0), Eigen::MatrixXd(0, 0)};
  // Squares of the entries must neither overflow nor vanish.
  const double scale = matrix.size() > 0 ? matrix.cwiseAbs().maxCoeff() : 0.0;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scale > 0 ? Eigen::MatrixXd(matrix / scale) : matrix);
  const Eigen::MatrixXd r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  SingularFactors out = FactorSquare(r, scale > 0 ? scale : 1.0, count_kept);
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(matrix.rows(), out.u.cols());
  u.topRows(n) = out.u;
  u.applyOnTheLeft(qr.householderQ());
  out.u = std::move(u);
  return out;
}

}  // namespace morphograph
