// The 6×6 system of one registration step, solved with its rank. Host and device share it: double precision, one
// thread.
#pragma once

#include <cmath>
#include <limits>

#include "plumbline/se3.h"

namespace plumbline::kernels {

/// 0.5 ξᵀ H ξ − bᵀ ξ, with ξ = (ω, v) a left increment: radians, metres.
struct NormalEquations {
  Matrix6d h = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
};

struct Solution {
  Vector6d step = Vector6d::Zero();  ///< (ω, v): radians, metres
  int rank = 0;                      ///< directions that the equations hold
};

namespace detail {

/// Eigen's own is for the host alone.
template <class Matrix>
PL_SHARED bool is_finite(const Matrix& m) {
  return m.cwiseAbs().sum() <= std::numeric_limits<double>::max();
}

/// L with L Lᵀ = m, lower triangle; false if m is not positive definite.
PL_SHARED bool cholesky(const Matrix6d& m, Matrix6d* l) {
  l->setZero();
  for (int j = 0; j < 6; ++j) {
    for (int i = j; i < 6; ++i) {
      double sum = m(i, j);
      for (int k = 0; k < j; ++k) sum -= (*l)(i, k) * (*l)(j, k);
      if (i > j) {
        (*l)(i, j) = sum / (*l)(j, j);
      } else {
        if (!(sum > 0)) return false;
        (*l)(j, j) = std::sqrt(sum);
      }
    }
  }
  return true;
}

/// x with L x = b.
PL_SHARED Vector6d forward(const Matrix6d& l, Vector6d b) {
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= l(i, k) * b[k];
    b[i] /= l(i, i);
  }
  return b;
}

/// x with Lᵀ x = b.
PL_SHARED Vector6d backward(const Matrix6d& l, Vector6d b) {
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) b[i] -= l(k, i) * b[k];
    b[i] /= l(i, i);
  }
  return b;
}

/// Trace of (L Lᵀ)⁻¹: the squares of L⁻¹.
PL_SHARED double inverse_trace(const Matrix6d& l) {
  double sum = 0;
  for (int j = 0; j < 6; ++j) {
    const Vector6d column = forward(l, Vector6d::Unit(j));
    sum += column.squaredNorm();
  }
  return sum;
}

/// Eigenvalues of a symmetric matrix on the diagonal of `m`, its eigenvectors in the columns of `vectors`: cyclic
/// Jacobi rotations (Golub, Van Loan, "Matrix Computations", 8.5).
PL_SHARED void diagonalise(Matrix6d* m, Matrix6d* vectors) {
  constexpr int kMaxSweeps = 30;
  Matrix6d& a = *m;
  vectors->setIdentity();
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double off = 0;
    for (int p = 0; p < 6; ++p)
      for (int q = p + 1; q < 6; ++q) off += a(p, q) * a(p, q);
    if (!(off > 1e-32 * a.squaredNorm())) return;
    for (int p = 0; p < 6; ++p) {
      for (int q = p + 1; q < 6; ++q) {
        if (a(p, q) == 0) continue;
        const double tau = (a(q, q) - a(p, p)) / (2 * a(p, q));
        const double t = (tau >= 0 ? 1 : -1) / (std::abs(tau) + std::sqrt(1 + tau * tau));
        const double c = 1 / std::sqrt(1 + t * t), s = t * c;
        for (int k = 0; k < 6; ++k) {
          const double kp = a(k, p), kq = a(k, q);
          a(k, p) = c * kp - s * kq;
          a(k, q) = s * kp + c * kq;
        }
        for (int k = 0; k < 6; ++k) {
          const double pk = a(p, k), qk = a(q, k), vp = (*vectors)(k, p), vq = (*vectors)(k, q);
          a(p, k) = c * pk - s * qk;
          a(q, k) = s * pk + c * qk;
          (*vectors)(k, p) = c * vp - s * vq;
          (*vectors)(k, q) = s * vp + c * vq;
        }
      }
    }
  }
}

}  // namespace detail

/// How the rotation's rows are scaled so that both blocks have the same trace, which makes rank and condition
/// independent of the unit of length. Zero if that is not possible: an empty block, or what is not a number.
PL_SHARED double rotation_scale(const Matrix6d& h) {
  const double rotation = h.topLeftCorner<3, 3>().trace(), translation = h.bottomRightCorner<3, 3>().trace();
  if (!detail::is_finite(h) || !(rotation > 0) || !(translation > 0)) return 0;
  return std::sqrt(translation / rotation);
}

PL_SHARED Matrix6d scaled(const Matrix6d& h, double rotation_scale) {
  Matrix6d s = h;
  s.topRows<3>() *= rotation_scale;
  s.leftCols<3>() *= rotation_scale;
  return s;
}

/// Solves H x = b for a symmetric positive semi-definite H. Directions whose eigenvalue, after scaling, is below
/// 1/`max_condition` of the largest are left out of the step and of the rank. Where the traces of H and of its inverse
/// say that there are none, which is nearly always, the factors of Cholesky are enough.
PL_SHARED Solution solve(const Matrix6d& h, const Vector6d& b, double max_condition) {
  Solution solution;
  const double scale = rotation_scale(h);
  if (scale == 0 || !detail::is_finite(b)) return solution;
  Matrix6d s = scaled(h, scale), l;
  Vector6d x = b;
  x.head<3>() *= scale;
  if (detail::cholesky(s, &l) && s.trace() * detail::inverse_trace(l) < max_condition) {
    solution.step = detail::backward(l, detail::forward(l, x));
    solution.rank = 6;
  } else {
    Matrix6d vectors;
    detail::diagonalise(&s, &vectors);
    const double largest = s.diagonal().maxCoeff();
    for (int i = 0; i < 6; ++i) {
      if (!(s(i, i) * max_condition > largest)) continue;
      solution.step += vectors.col(i) * (vectors.col(i).dot(x) / s(i, i));
      ++solution.rank;
    }
  }
  solution.step.head<3>() *= scale;
  return solution;
}

}  // namespace plumbline::kernels
