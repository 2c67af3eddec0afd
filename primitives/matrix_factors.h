#pragma once

#include <Eigen/Core>
#include <functional>

namespace morphograph {

// Decompositions behind plain functions: Eigen's are templates that every source which uses one would compile again.

/// A symmetric matrix as vectors diag(values) vectors^T.
struct SymmetricFactors {
  Eigen::VectorXd values;   // (n), smallest first
  Eigen::MatrixXd vectors;  // (n x n), orthonormal columns
};

/// @param matrix  (n x n); only its lower triangle is read.
/// @throws std::runtime_error when the iteration does not converge, as with values that are not finite.
SymmetricFactors FactorSymmetric(const Eigen::MatrixXd& matrix);

/// The leading part of X = u diag(values) v^T.
struct SingularFactors {
  Eigen::VectorXd values;  // (min(rows, columns)), all of them, largest first; beyond the numerical rank they are rounding
  Eigen::MatrixXd u;       // (rows x kept), orthonormal columns
  Eigen::MatrixXd v;       // (columns x kept)
};

/// Singular value decomposition by one-sided Jacobi rotations (Hestenes 1958; Demmel & Veselic 1992), which find small
/// values as exactly as large ones. It starts from the eigenvectors of the Gram matrix, which alone would lose the values
/// below 1e-8 of the largest; so few rotations are left. A longer side is first brought down by QR.
///
/// @param count_kept  tells from the values how many axes are wanted, fewer being cheaper; all when empty. Never more
///                    than the numerical rank are given.
/// @throws std::runtime_error when the iteration does not converge, as with values that are not finite.
SingularFactors FactorSingular(const Eigen::MatrixXd& matrix,
                               const std::function<Eigen::Index(const Eigen::VectorXd& values)>& count_kept = {});

}  // namespace morphograph
