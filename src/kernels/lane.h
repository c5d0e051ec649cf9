// The lane type: kernels are written once over F, which is `float` on a GPU thread (and in a test of one pixel) and
// `xsimd::batch<float>` on the CPU (several neighbouring pixels at once). This header gives both the same vocabulary.
//
// Kernels are branch-free where lanes may differ: masks and `select` in place of `if`. A branch is allowed on values
// that are the same for all lanes, and on `any(mask)`.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/plane.h"
#include "plumbline/macros.h"

#if !defined(__CUDACC__)
#include <xsimd/xsimd.hpp>
#endif

namespace plumbline::kernels {

/// Types that go with lane type F.
template <class F>
struct Lane;

template <>
struct Lane<float> {
  using Int = std::int32_t;
  using Mask = bool;
  static constexpr int width = 1;
  static PL_HD float index() { return 0.0f; }
  static PL_HD std::int32_t int_index() { return 0; }
};

template <class F>
using Int = typename Lane<F>::Int;
template <class F>
using Mask = typename Lane<F>::Mask;

// ---- float ----------------------------------------------------------------------------------------------------------

PL_HD float select(bool mask, float yes, float no) { return mask ? yes : no; }
PL_HD std::int32_t select_int(bool mask, std::int32_t yes, std::int32_t no) { return mask ? yes : no; }
PL_HD bool any(bool mask) { return mask; }
PL_HD bool all(bool mask) { return mask; }
PL_HD float min(float a, float b) { return a < b ? a : b; }
PL_HD float max(float a, float b) { return a > b ? a : b; }
PL_HD float abs(float a) { return a < 0 ? -a : a; }
PL_HD float sqrt(float a) { return ::sqrtf(a); }
PL_HD float floor(float a) { return ::floorf(a); }
PL_HD float madd(float a, float b, float c) { return ::fmaf(a, b, c); }
PL_HD std::int32_t to_int(float a) { return static_cast<std::int32_t>(a); }
PL_HD float to_float(std::int32_t a) { return static_cast<float>(a); }
PL_HD std::int32_t min_int(std::int32_t a, std::int32_t b) { return a < b ? a : b; }
PL_HD std::int32_t max_int(std::int32_t a, std::int32_t b) { return a > b ? a : b; }
/// What lies in [0, 2n) as in a ring of n: [0, n).
PL_HD std::int32_t wrap_int(std::int32_t a, std::int32_t n) { return a < n ? a : a - n; }
template <int N>
PL_HD std::int32_t shift_left(std::int32_t a) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) << N);
}
template <int N>
PL_HD std::int32_t shift_right(std::int32_t a) {
  return a >> N;
}
PL_HD std::int32_t shift_left_by(std::int32_t a, std::int32_t n) { return a << n; }
PL_HD std::int32_t shift_right_by(std::int32_t a, std::int32_t n) { return a >> n; }
PL_HD bool equal(std::int32_t a, std::int32_t b) { return a == b; }
PL_HD float float_from_bits(std::int32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}
PL_HD std::int32_t bits_from_float(float value) {
  std::int32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}
template <class F>
PL_HD F load(const float* p);
template <>
PL_HD float load<float>(const float* p) {
  return *p;
}
template <class F>
PL_HD Int<F> load_int(const std::int32_t* p);
template <>
PL_HD std::int32_t load_int<float>(const std::int32_t* p) {
  return *p;
}
template <class F>
PL_HD F load_u16(const std::uint16_t* p);
template <>
PL_HD float load_u16<float>(const std::uint16_t* p) {
  return static_cast<float>(*p);
}
PL_HD void store(float* p, float a) { *p = a; }
PL_HD void store_int(std::int32_t* p, std::int32_t a) { *p = a; }
PL_HD void store_u8(std::uint8_t* p, float a) { *p = static_cast<std::uint8_t>(a); }
PL_HD float gather(const float* p, std::int32_t i) { return p[i]; }
PL_HD std::int32_t gather_int(const std::int32_t* p, std::int32_t i) { return p[i]; }

#if !defined(__CUDACC__)

// ---- xsimd ----------------------------------------------------------------------------------------------------------

template <class A>
using FloatBatch = xsimd::batch<float, A>;
template <class A>
using IntBatch = xsimd::batch<std::int32_t, A>;
template <class A>
using BatchMask = xsimd::batch_bool<float, A>;

template <class A>
struct Lane<FloatBatch<A>> {
  using Int = IntBatch<A>;
  using Mask = BatchMask<A>;
  static constexpr int width = static_cast<int>(FloatBatch<A>::size);

  static PL_HD FloatBatch<A> index() { return xsimd::to_float(int_index()); }
  static PL_HD IntBatch<A> int_index() {
    alignas(64) static constexpr std::int32_t indices[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    return IntBatch<A>::load_unaligned(indices);
  }
};

template <class A>
PL_HD FloatBatch<A> select(const BatchMask<A>& mask, const FloatBatch<A>& yes, const FloatBatch<A>& no) {
  return xsimd::select(mask, yes, no);
}
template <class A>
PL_HD IntBatch<A> select_int(const BatchMask<A>& mask, const IntBatch<A>& yes, const IntBatch<A>& no) {
  return xsimd::bitwise_cast<IntBatch<A>>(
      xsimd::select(mask, xsimd::bitwise_cast<FloatBatch<A>>(yes), xsimd::bitwise_cast<FloatBatch<A>>(no)));
}
template <class A>
PL_HD bool any(const BatchMask<A>& mask) {
  return xsimd::any(mask);
}
template <class A>
PL_HD bool all(const BatchMask<A>& mask) {
  return xsimd::all(mask);
}
template <class A>
PL_HD FloatBatch<A> min(const FloatBatch<A>& a, const FloatBatch<A>& b) {
  return xsimd::min(a, b);
}
template <class A>
PL_HD FloatBatch<A> max(const FloatBatch<A>& a, const FloatBatch<A>& b) {
  return xsimd::max(a, b);
}
template <class A>
PL_HD FloatBatch<A> abs(const FloatBatch<A>& a) {
  return xsimd::abs(a);
}
template <class A>
PL_HD FloatBatch<A> sqrt(const FloatBatch<A>& a) {
  return xsimd::sqrt(a);
}
template <class A>
PL_HD FloatBatch<A> floor(const FloatBatch<A>& a) {
  return xsimd::floor(a);
}
template <class A>
PL_HD FloatBatch<A> madd(const FloatBatch<A>& a, const FloatBatch<A>& b, const FloatBatch<A>& c) {
  return xsimd::fma(a, b, c);
}
template <class A>
PL_HD IntBatch<A> to_int(const FloatBatch<A>& a) {
  return xsimd::to_int(a);
}
template <class A>
PL_HD FloatBatch<A> to_float(const IntBatch<A>& a) {
  return xsimd::to_float(a);
}
template <class A>
PL_HD IntBatch<A> min_int(const IntBatch<A>& a, const IntBatch<A>& b) {
  return xsimd::min(a, b);
}
template <class A>
PL_HD IntBatch<A> max_int(const IntBatch<A>& a, const IntBatch<A>& b) {
  return xsimd::max(a, b);
}
template <class A>
PL_HD IntBatch<A> wrap_int(const IntBatch<A>& a, std::int32_t n) {
  // Without a sign a − n is the smaller one only where it is not below zero.
  using Unsigned = xsimd::batch<std::uint32_t, A>;
  return xsimd::bitwise_cast<IntBatch<A>>(
      xsimd::min(xsimd::bitwise_cast<Unsigned>(a), xsimd::bitwise_cast<Unsigned>(a - IntBatch<A>(n))));
}
template <class A>
PL_HD BatchMask<A> equal(const IntBatch<A>& a, const IntBatch<A>& b) {
  return xsimd::bool_cast(a == b);
}
template <int N, class A>
PL_HD IntBatch<A> shift_left(const IntBatch<A>& a) {
  return a << N;
}
template <int N, class A>
PL_HD IntBatch<A> shift_right(const IntBatch<A>& a) {
  return a >> N;
}
template <class A>
PL_HD IntBatch<A> shift_left_by(const IntBatch<A>& a, const IntBatch<A>& n) {
  return a << n;
}
template <class A>
PL_HD IntBatch<A> shift_right_by(const IntBatch<A>& a, const IntBatch<A>& n) {
  return a >> n;
}

template <class F>
PL_HD F load(const float* p) {
  return F::load_unaligned(p);
}
template <class F>
PL_HD Int<F> load_int(const std::int32_t* p) {
  return Int<F>::load_unaligned(p);
}
template <class F>
PL_HD F load_u16(const std::uint16_t* p) {
  alignas(64) std::int32_t wide[Lane<F>::width];
  for (int i = 0; i < Lane<F>::width; ++i) wide[i] = p[i];
  return xsimd::to_float(Int<F>::load_aligned(wide));
}
template <class A>
PL_HD void store(float* p, const FloatBatch<A>& a) {
  a.store_unaligned(p);
}
template <class A>
PL_HD void store_int(std::int32_t* p, const IntBatch<A>& a) {
  a.store_unaligned(p);
}
template <class A>
PL_HD void store_u8(std::uint8_t* p, const FloatBatch<A>& a) {
  alignas(64) std::int32_t wide[FloatBatch<A>::size];
  xsimd::to_int(a).store_aligned(wide);
  for (std::size_t i = 0; i < FloatBatch<A>::size; ++i) p[i] = static_cast<std::uint8_t>(wide[i]);
}
/// Elements of a gather one by one, in registers of four: on Zen 5 and on processors that are guarded against Downfall
/// this beats the gather instruction, and xsimd's own inserts them one after the other into the widest register.
template <class A>
PL_HD IntBatch<A> gather_int(const std::int32_t* p, const IntBatch<A>& index) {
#if defined(__AVX2__)
  alignas(64) std::int32_t i[IntBatch<A>::size];
  index.store_aligned(i);
  const auto four = [&](int first) {
    const std::int32_t* j = i + first;
    const __m128i one = _mm_cvtsi32_si128(p[j[0]]), two = _mm_insert_epi32(one, p[j[1]], 1);
    return _mm_insert_epi32(_mm_insert_epi32(two, p[j[2]], 2), p[j[3]], 3);
  };
  const auto eight = [&](int first) {
    return _mm256_inserti128_si256(_mm256_castsi128_si256(four(first)), four(first + 4), 1);
  };
#if defined(__AVX512F__)
  if constexpr (IntBatch<A>::size == 16)
    return _mm512_inserti64x4(_mm512_castsi256_si512(eight(0)), eight(8), 1);
  else
#endif
    return eight(0);
#else
  return IntBatch<A>::gather(p, index);
#endif
}
template <class A>
PL_HD FloatBatch<A> gather(const float* p, const IntBatch<A>& index) {
#if defined(__AVX2__)
  return xsimd::bitwise_cast<FloatBatch<A>>(gather_int(reinterpret_cast<const std::int32_t*>(p), index));
#else
  return FloatBatch<A>::gather(p, index);
#endif
}
template <class A>
PL_HD FloatBatch<A> float_from_bits(const IntBatch<A>& bits) {
  return xsimd::bitwise_cast<FloatBatch<A>>(bits);
}
template <class A>
PL_HD IntBatch<A> bits_from_float(const FloatBatch<A>& value) {
  return xsimd::bitwise_cast<IntBatch<A>>(value);
}

#endif

/// Lanes as a block of pixels, row by row.
template <class F>
struct Block {
  static constexpr int column_bits = Lane<F>::width >= 8 ? 2 : Lane<F>::width >= 4 ? 1 : 0;
  static constexpr int width = 1 << column_bits, height = Lane<F>::width / width;

  static PL_HD F columns() { return to_float(Lane<F>::int_index() & Int<F>(width - 1)); }
  static PL_HD F rows() { return to_float(shift_right<column_bits>(Lane<F>::int_index())); }
};

/// A value for every lane.
template <class F>
PL_HD F broadcast(float value) {
  return F(value);
}

/// Lanes whose column lies inside the image; the others are padding.
template <class F>
PL_HD Mask<F> inside_row(int x, int width) {
  return Lane<F>::index() < F(static_cast<float>(width - x));
}

/// Stores `a`, and zeros (an invalid reading) in the lanes that `mask` leaves out: the padding of a plane stays zero.
template <class F>
PL_HD void store_masked(float* p, const F& a, const Mask<F>& mask) {
  store(p, select(mask, a, F(0.0f)));
}

/// The same for a block of pixels; rows below the image are left out.
template <class F>
PL_HD void store_block(const PlaneView<float>& plane, int x, int y, const F& a, const Mask<F>& mask) {
  alignas(64) float values[Lane<F>::width];
  store(values, select(mask, a, F(0.0f)));
  for (int row = 0; row < Block<F>::height && y + row < plane.height; ++row)
    memcpy(plane.row(y + row) + x, values + row * Block<F>::width, sizeof(float) * Block<F>::width);
}

}  // namespace plumbline::kernels
