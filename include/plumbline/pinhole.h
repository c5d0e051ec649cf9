// The pinhole camera: x right, y down, z forward; pixel (0, 0) is the *centre* of the top-left pixel.
#pragma once

#include <cmath>

#include "plumbline/vec3.h"

namespace plumbline {

/// Intrinsics in pixels of an image of width × height. `fy` may be negative (ICL-NUIM: y up).
struct Pinhole {
  float fx = 0, fy = 0, cx = 0, cy = 0;
  int width = 0, height = 0;

  /// The camera of the image decimated `level` times by two. A coarse pixel covers 2×2 fine ones, so its centre lies
  /// half a fine pixel off theirs: c' = (c + ½)/2 − ½. Odd last rows and columns fall away.
  Pinhole level(int level) const {
    Pinhole k = *this;
    for (int i = 0; i < level; ++i) {
      k.fx *= 0.5f;
      k.fy *= 0.5f;
      k.cx = (k.cx + 0.5f) * 0.5f - 0.5f;
      k.cy = (k.cy + 0.5f) * 0.5f - 0.5f;
      k.width /= 2;
      k.height /= 2;
    }
    return k;
  }

  /// Point at depth z (metres along the optical axis) seen at pixel (u, v).
  template <class F>
  PL_HD Vec3<F> back_project(const F& u, const F& v, const F& z) const {
    return {(u - cx) * (1.0f / fx) * z, (v - cy) * (1.0f / fy) * z, z};
  }

  bool is_valid() const {
    return width > 0 && height > 0 && std::isfinite(fx) && std::isfinite(fy) && std::isfinite(cx) &&
           std::isfinite(cy) && fx > 0 && fy != 0;
  }
  bool operator==(const Pinhole&) const = default;
};

/// Brown–Conrady lens distortion in OpenCV's order, with a rational radial part (k4 to k6); all zero means none.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;

  bool is_rational() const { return k4 != 0 || k5 != 0 || k6 != 0; }
  bool is_zero() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0 && !is_rational(); }
  bool operator==(const Distortion&) const = default;

  /// Normalised image coordinates (x/z, y/z) without distortion to those with it (Brown 1971).
  void apply(double x, double y, double* x_distorted, double* y_distorted) const {
    const double r2 = x * x + y * y;
    const double radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
    *x_distorted = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    *y_distorted = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  }
};

}  // namespace plumbline
