// Random numbers as a function of a key and a counter: the same for any order of evaluation and number of threads
// (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", 2011).
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace plumbline {

/// A bijection of 64 bits that scatters neighbouring values (the finaliser of SplitMix64: Steele, Lea, Flood 2014).
constexpr std::uint64_t scramble(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Key of an independent stream, from the key of its parent and a number that names it.
constexpr std::uint64_t stream(std::uint64_t key, std::uint64_t name) {
  return scramble(key + 0x9e3779b97f4a7c15ULL * (name + 1));
}

/// [0, 1), number `counter` of a stream.
constexpr double uniform_at(std::uint64_t key, std::uint64_t counter) {
  return static_cast<double>(stream(key, counter) >> 11) * 0x1p-53;
}

/// Standard normal deviate, number `counter` of a stream (Box and Muller 1958).
inline double normal_at(std::uint64_t key, std::uint64_t counter) {
  const std::uint64_t bits = stream(key, counter);
  const double u = (static_cast<double>(bits >> 32) + 0.5) * 0x1p-32;
  const double v = static_cast<double>(bits & 0xffffffffULL) * 0x1p-32;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

/// [0, 1). The engine's numbers are prescribed by the standard, those of its distributions are not.
inline double uniform(std::mt19937_64* random) { return static_cast<double>((*random)() >> 11) * 0x1p-53; }

/// The numbers of a stream one after the other, for code that runs in one order anyway.
class Random {
 public:
  explicit Random(std::uint64_t key) : key_(key) {}

  double uniform() { return uniform_at(key_, counter_++); }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal() { return normal_at(key_, counter_++); }
  /// 0 … count − 1.
  int below(int count) { return static_cast<int>(uniform() * count); }

 private:
  std::uint64_t key_, counter_ = 0;
};

}  // namespace plumbline
