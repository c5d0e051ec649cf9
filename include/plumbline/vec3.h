// Small fixed-size vectors over any lane type: plain aggregates that a host, a SIMD lane and a GPU thread share.
#pragma once

#include "plumbline/macros.h"

namespace plumbline {

/// Three components of lane type F. Unit and frame are those of the variable's name.
template <class F>
struct Vec3 {
  F x, y, z;
};

template <class F>
PL_HD Vec3<F> operator+(const Vec3<F>& a, const Vec3<F>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class F>
PL_HD Vec3<F> operator-(const Vec3<F>& a, const Vec3<F>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class F, class S>
PL_HD Vec3<F> operator*(const Vec3<F>& a, const S& s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class F>
PL_HD F dot(const Vec3<F>& a, const Vec3<F>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class F>
PL_HD Vec3<F> cross(const Vec3<F>& a, const Vec3<F>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Rigid transform in single precision for kernels: `a_from_b.apply(p_b) == p_a`. Made from an SE3 by `to_kernel`.
struct RigidTransform {
  float r[9];  ///< rotation, row-major
  float t[3];  ///< translation, metres

  template <class F>
  PL_HD Vec3<F> rotate(const Vec3<F>& p) const {
    return {r[0] * p.x + r[1] * p.y + r[2] * p.z, r[3] * p.x + r[4] * p.y + r[5] * p.z,
            r[6] * p.x + r[7] * p.y + r[8] * p.z};
  }
  template <class F>
  PL_HD Vec3<F> apply(const Vec3<F>& p) const {
    const Vec3<F> q = rotate(p);
    return {q.x + t[0], q.y + t[1], q.z + t[2]};
  }
};

}  // namespace plumbline
