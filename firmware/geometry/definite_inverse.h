#pragma once
/// The inverse of an information matrix, or of a covariance.
#include <Eigen/Core>

namespace ninedot {

/// Of a symmetric, positive definite matrix of some ten rows: Gauss and Jordan's method in place. Such a matrix needs
/// no pivots, without which each step is one product of vectors: of eleven rows it takes a quarter of the instructions
/// of Eigen's inverse() and of its Cholesky decomposition, which are made for larger ones. \param A  of any unit [1],
/// finite; of one that is not definite the result is no inverse, or not finite \return  A^-1 [1], in the inverse of
/// that unit, symmetric to rounding. Memory: none. Threads: pure.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> inverse_of_definite(Eigen::Matrix<double, kSize, kSize> A) noexcept {
  for (Eigen::Index k = 0; k < kSize; ++k) {
    const double per_pivot = 1 / A(k, k);
    const Eigen::Matrix<double, kSize, 1> column = A.col(k), scaled = per_pivot * column;
    for (Eigen::Index j = 0; j < kSize; ++j) A.col(j) -= column(j) * scaled;
    A.col(k) = scaled;
    A.row(k) = scaled.transpose();
    A(k, k) = -per_pivot;
  }
  return -A;
}

}  // namespace ninedot
