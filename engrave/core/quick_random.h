#pragma once

// Random numbers for algorithms that draw hundreds of millions of them: xoshiro256++
// (Blackman and Vigna, "Scrambled linear pseudorandom number generators", 2021), seeded
// by splitmix64 as its authors advise. A fifth of the time of std::mt19937_64, whose
// state of 2.5 kB takes part of the cache. The same numbers with every standard library.

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

namespace intaglio {

class QuickRandom {
 public:
  using result_type = std::uint64_t;

  explicit QuickRandom(std::uint64_t seed = 0) { Seed(seed); }

  void Seed(std::uint64_t seed) {
    for (std::uint64_t& part : state_) {
      seed += 0x9e3779b97f4a7c15;
      std::uint64_t mixed = seed;
      mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9;
      mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111eb;
      part = mixed ^ (mixed >> 31);
    }
  }

  std::uint64_t operator()() {
    auto& [a, b, c, d] = state_;
    const std::uint64_t drawn = std::rotl(a + d, 23) + a;
    const std::uint64_t shifted = b << 17;
    c ^= a;
    d ^= b;
    b ^= c;
    a ^= d;
    c ^= shifted;
    d = std::rotl(d, 45);
    return drawn;
  }

  static constexpr std::uint64_t min() { return 0; }
  static constexpr std::uint64_t max() {
    return std::numeric_limits<std::uint64_t>::max();
  }

 private:
  std::array<std::uint64_t, 4> state_;
};

}  // namespace intaglio
