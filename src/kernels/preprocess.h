// From a raw depth image to what registration needs: metres, smoothed depth, a pyramid, normals. docs/method.md §1.
//
// A reading of zero means "none" everywhere, and so does the padding around each plane; see PlaneView.
#pragma once

#include "kernels/lane.h"
#include "plumbline/pinhole.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// 2^x for x ≤ 0, relative error below 2e-4 down to 2⁻²⁴, which smaller ones become too. The sum with 1.5·2²³ rounds x
/// to a whole number and holds it in its lowest bits, whence it goes into the exponent; a cubic stands for the rest.
template <class F>
PL_HD F exp2_negative(const F& exponent) {
  constexpr float kRound = 12582912.0f;
  const F x = max(exponent, F(-24.0f));
  const F rounded = x + kRound;
  const F fraction = x - (rounded - kRound);  // −½ … ½
  F p = madd(fraction, F(0.0560253f), F(0.2402265f));
  p = madd(fraction, p, F(0.6931472f));
  p = madd(fraction, p, F(1.0f));
  return float_from_bits(bits_from_float(p) + shift_left<23>(bits_from_float(rounded)));
}

/// Raw readings to metres; readings out of [min_depth, max_depth] become none.
struct ToMetres {
  PlaneView<const std::uint16_t> raw;
  PlaneView<float> depth;
  float metres_per_reading, min_depth, max_depth;

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const F z = load_u16<F>(raw.row(y) + x) * metres_per_reading;
    const auto valid = inside_row<F>(x, depth.width) && z >= F(min_depth) && z <= F(max_depth) && z > F(0.0f);
    store_masked<F>(depth.row(y) + x, z, valid);
  }
};

/// Edge-preserving smoothing (Tomasi and Manduchi 1998) with Gaussian weights in the image and in depth.
struct BilateralFilter {
  PlaneView<const float> in;
  PlaneView<float> out;
  int radius;
  float inverse_two_sigma_space2;  ///< 1 / (2 σ_space²), 1/px²
  float inverse_two_sigma_range2;  ///< 1 / (2 σ_range²), 1/m²

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const F centre = load<F>(in.row(y) + x);
    const auto valid = inside_row<F>(x, in.width) && centre > F(0.0f);
    F sum(0.0f), weights(0.0f);
    if (any(valid)) {
      constexpr float kLog2E = 1.44269504f;
      const float space = -kLog2E * inverse_two_sigma_space2;
      const F range(-kLog2E * inverse_two_sigma_range2);
      const int y0 = y - radius < 0 ? 0 : y - radius;
      const int y1 = y + radius >= in.height ? in.height - 1 : y + radius;
      for (int yy = y0; yy <= y1; ++yy) {
        const float* row = in.row(yy) + x;
        const float dy2 = static_cast<float>((yy - y) * (yy - y));
        add_tap(load<F>(row), centre, range, F(dy2 * space), &sum, &weights);
        for (int dx = 1; dx <= radius; ++dx) {
          const F exponent((static_cast<float>(dx * dx) + dy2) * space);
          add_tap(load<F>(row - dx), centre, range, exponent, &sum, &weights);
          add_tap(load<F>(row + dx), centre, range, exponent, &sum, &weights);
        }
      }
    }
    store_masked<F>(out.row(y) + x, centre + sum / max(weights, F(1e-20f)), valid);
  }

 private:
  /// The difference of a reading z from the centre, with the weight 2^(range·(z − centre)² + space). Differences, as
  /// sums of depths would lose the digits that the filter is for.
  template <class F>
  PL_HD static void add_tap(const F& z, const F& centre, const F& range, const F& space, F* sum, F* weights) {
    const F dz = z - centre;
    const F w = select(z > F(0.0f), exp2_negative(madd(dz * dz, range, space)), F(0.0f));
    *sum = madd(w, dz, *sum);
    *weights = *weights + w;
  }
};

/// Depth at half the size: the mean of the 2×2 block's readings that lie within `range` of its nearest one, so that a
/// coarse pixel never mixes the two sides of an edge.
struct DecimateDepth {
  PlaneView<const float> fine;
  PlaneView<float> coarse;
  float range;  ///< metres

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const F none(1e30f);
    F z[4];
    for (int k = 0; k < 4; ++k) {
      const float* row = fine.row(2 * y + k / 2) + 2 * x + k % 2;
      const F reading = gather(row, shift_left<1>(Lane<F>::int_index()));
      z[k] = select(reading > F(0.0f), reading, none);
    }
    const F nearest = min(min(z[0], z[1]), min(z[2], z[3]));
    F sum(0.0f), count(0.0f);
    for (int k = 0; k < 4; ++k) {
      const auto same_surface = z[k] - nearest <= F(range);
      sum = sum + select(same_surface, z[k], F(0.0f));
      count = count + select(same_surface, F(1.0f), F(0.0f));
    }
    const auto valid = inside_row<F>(x, coarse.width) && nearest < F(1e29f);
    store_masked<F>(coarse.row(y) + x, sum / count, valid);
  }
};

/// A normal map: unit vectors towards the camera in its frame, or zeros.
struct NormalPlanes {
  PlaneView<float> x, y, z;
};

template <class F>
PL_HD void store_normal(const NormalPlanes& planes, int x, int y, const Vec3<F>& n, const Mask<F>& valid) {
  store_masked<F>(planes.x.row(y) + x, n.x, valid);
  store_masked<F>(planes.y.row(y) + x, n.y, valid);
  store_masked<F>(planes.z.row(y) + x, n.z, valid);
}

/// Unit normal facing the camera from an unoriented, unscaled one at the pixel's viewing ray.
template <class F>
PL_HD Vec3<F> orient_to_camera(const Vec3<F>& n, const Vec3<F>& point) {
  const F scale = F(1.0f) / sqrt(max(dot(n, n), F(1e-30f)));
  return n * select(dot(n, point) > F(0.0f), F(0.0f) - scale, scale);
}

/// 1/z, and 0 where there is no reading: what the plane fit takes from every pixel's window, divided once.
struct InverseDepth {
  PlaneView<const float> depth;
  PlaneView<float> inverse;

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const F z = load<F>(depth.row(y) + x);
    const auto valid = inside_row<F>(x, depth.width) && z > F(0.0f);
    store_masked<F>(inverse.row(y) + x, F(1.0f) / select(valid, z, F(1.0f)), valid);
  }
};

/// Normals by a local plane. A plane n·p = d is *linear* in the inverse depth, 1/z = (n·(x/z, y/z, 1)) / d, and the
/// noise of a triangulating sensor is uniform in 1/z, so the least-squares fit of 1/z over the window is the plane's
/// best estimate without an eigen-decomposition. Pixels of other surfaces are left out by a relative depth gate.
struct PlaneNormals {
  PlaneView<const float> depth, inverse_depth;
  NormalPlanes normals;
  Pinhole camera;
  int radius;
  float depth_gate;  ///< fraction of the centre's depth

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const F centre = load<F>(depth.row(y) + x);
    const auto inside = inside_row<F>(x, depth.width) && centre > F(0.0f);
    if (!any(inside)) return store_normal<F>(normals, x, y, {F(0.0f), F(0.0f), F(0.0f)}, inside);

    // Sums over the window of 1, i, j, i², ij, j² and of w, i·w, j·w, with w = centre/z − 1.
    F n(0.0f), si(0.0f), sj(0.0f), sii(0.0f), sij(0.0f), sjj(0.0f), sw(0.0f), siw(0.0f), sjw(0.0f);
    // |z − centre| ≤ gate·centre, in terms of w.
    const F lowest(1.0f / (1.0f + depth_gate) - 1.0f);
    const F highest(depth_gate < 1.0f ? 1.0f / (1.0f - depth_gate) - 1.0f : 1e30f);
    const int j0 = y < radius ? -y : -radius;
    const int j1 = y + radius >= depth.height ? depth.height - 1 - y : radius;
    for (int j = j0; j <= j1; ++j) {
      const float* row = inverse_depth.row(y + j) + x;
      F rn(0.0f), ri(0.0f), rii(0.0f), rw(0.0f), riw(0.0f);
      for (int i = -radius; i <= radius; ++i) {
        const F difference = madd(centre, load<F>(row + i), F(-1.0f));
        const auto same_surface = difference >= lowest && difference <= highest;
        const F one = select(same_surface, F(1.0f), F(0.0f));
        const F w = select(same_surface, difference, F(0.0f));
        const float fi = static_cast<float>(i);
        rn = rn + one;
        ri = madd(one, F(fi), ri);
        rii = madd(one, F(fi * fi), rii);
        rw = rw + w;
        riw = madd(w, F(fi), riw);
      }
      const float fj = static_cast<float>(j);
      n = n + rn;
      si = si + ri;
      sii = sii + rii;
      sw = sw + rw;
      siw = siw + riw;
      sj = madd(rn, F(fj), sj);
      sij = madd(ri, F(fj), sij);
      sjj = madd(rn, F(fj * fj), sjj);
      sjw = madd(rw, F(fj), sjw);
    }
    // Centre the sums and solve the 2×2 system for the slopes a = ∂w/∂i, b = ∂w/∂j; then w at the centre pixel.
    const F inverse_n = F(1.0f) / max(n, F(1.0f));
    const F mi = si * inverse_n, mj = sj * inverse_n, mw = sw * inverse_n;
    const F cii = sii - si * mi, cij = sij - si * mj, cjj = sjj - sj * mj;
    const F ciw = siw - si * mw, cjw = sjw - sj * mw;
    const F determinant = cii * cjj - cij * cij;
    const auto valid = inside && n >= F(4.0f) && determinant > F(0.5f);
    const F inverse = F(1.0f) / select(valid, determinant, F(1.0f));
    const F a = (ciw * cjj - cjw * cij) * inverse;
    const F b = (cjw * cii - ciw * cij) * inverse;
    const F c = mw - a * mi - b * mj + 1.0f;  // centre/z at the centre pixel, of the fitted plane

    // centre/z = a (u − u₀) + b (v − v₀) + c with u = fx·(x/z) + cx: the normal is the gradient in (x/z, y/z, 1).
    const F u0 = Lane<F>::index() + static_cast<float>(x);
    const float v0 = static_cast<float>(y);
    const Vec3<F> normal = {a * camera.fx, b * camera.fy, a * (F(camera.cx) - u0) + b * F(camera.cy - v0) + c};
    const Vec3<F> ray = camera.back_project(u0, F(v0), F(1.0f));
    store_normal<F>(normals, x, y, orient_to_camera(normal, ray), valid);
  }
};

}  // namespace plumbline::kernels
