#include "engrave/discretize/picture/halftone_mask.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

// Every taken place adds a Gaussian to the crowding of all places. The tightest cluster
// is the taken place of maximum crowding, the largest void the free one of minimum
// crowding.
//   1. Random places, a tenth; the tightest cluster moves into the largest void until it
//      would move back.
//   2. From there down: the tightest cluster leaves, and gets the highest rank left.
//   3. From there up: the largest void is taken, and gets the next rank. (Ulichney's
//      third phase, in which the free places are the minority, does the same: the
//      crowding by free places is a constant minus the one by taken places.)

namespace intaglio::discretize {
namespace {

constexpr int kSide = HalftoneMask::kSide;
constexpr int kReach = 9;
constexpr double kSigma = 1.5;  // steps; Ulichney's choice

class Filling {
 public:
  explicit Filling(std::uint64_t seed) {
    for (int parity = 0; parity < 2; ++parity) {
      for (int dy = -kReach; dy <= kReach; ++dy) {
        for (int dx = -kReach; dx <= kReach; ++dx) {
          // An odd row is half a step to the right of an even one, and an even row half a
          // step to the left of an odd one.
          const double shift = dy % 2 == 0 ? 0 : (parity == 0 ? 0.5 : -0.5);
          const double square = (dx + shift) * (dx + shift) + 0.75 * dy * dy;
          weight_[parity][dy + kReach][dx + kReach] =
              std::lround(std::exp(-square / (2 * kSigma * kSigma)) * (1 << 20));
        }
      }
    }
    std::mt19937_64 random(seed);
    while (count_ < kSide * kSide / 10) {
      const int place = static_cast<int>(random() >> 50);
      static_assert(kSide * kSide == 1 << 14);
      if (!taken_[Index(place)]) Change(place, true);
    }
    while (true) {
      const int cluster = Extreme(true);
      Change(cluster, false);
      const int gap = Extreme(false);
      Change(gap, true);
      if (gap == cluster) break;
    }
  }

  std::vector<std::uint16_t> Ranks() {
    std::vector<std::uint16_t> rank(kSide * kSide);
    const Filling start = *this;
    while (count_ > 0) {
      const int cluster = Extreme(true);
      Change(cluster, false);
      rank[Index(cluster)] = static_cast<std::uint16_t>(count_);
    }
    *this = start;
    while (count_ < kSide * kSide) {
      const int gap = Extreme(false);
      rank[Index(gap)] = static_cast<std::uint16_t>(count_);
      Change(gap, true);
    }
    return rank;
  }

 private:
  static std::size_t Index(int place) { return static_cast<std::size_t>(place); }

  void Change(int place, bool take) {
    const int x = place % kSide, y = place / kSide;
    taken_[Index(place)] = take;
    count_ += take ? 1 : -1;
    const std::int64_t sign = take ? 1 : -1;
    for (int dy = -kReach; dy <= kReach; ++dy) {
      const int row = (y + dy + kSide) % kSide;
      const std::int64_t* weight = weight_[y % 2][dy + kReach];
      for (int dx = -kReach; dx <= kReach; ++dx) {
        crowding_[Index(row * kSide + (x + dx + kSide) % kSide)] +=
            sign * weight[dx + kReach];
      }
      stale_[Index(row)] = true;
    }
  }

  /// The taken place of maximum crowding, or the free place of minimum crowding; the
  /// first of equals. Only rows that changed are searched again.
  int Extreme(bool taken) {
    int best = -1;
    std::int64_t smallest = std::numeric_limits<std::int64_t>::max();
    for (int row = 0; row < kSide; ++row) {
      if (stale_[Index(row)]) Scan(row);
      const int place = extreme_[taken][Index(row)];
      if (place < 0) continue;
      const std::int64_t value = Signed(place, taken);
      if (value < smallest) {
        smallest = value;
        best = place;
      }
    }
    return best;
  }

  std::int64_t Signed(int place, bool taken) const {
    return taken ? -crowding_[Index(place)] : crowding_[Index(place)];
  }

  void Scan(int row) {
    int best[2] = {-1, -1};
    for (int place = row * kSide; place < (row + 1) * kSide; ++place) {
      const bool taken = taken_[Index(place)];
      int& at = best[taken];
      if (at < 0 || Signed(place, taken) < Signed(at, taken)) at = place;
    }
    extreme_[0][Index(row)] = best[0];
    extreme_[1][Index(row)] = best[1];
    stale_[Index(row)] = false;
  }

  std::int64_t weight_[2][2 * kReach + 1][2 * kReach + 1] = {};
  std::vector<std::int64_t> crowding_ = std::vector<std::int64_t>(kSide * kSide);
  std::vector<std::uint8_t> taken_ = std::vector<std::uint8_t>(kSide * kSide);
  std::vector<int> extreme_[2] = {std::vector<int>(kSide), std::vector<int>(kSide)};
  std::vector<std::uint8_t> stale_ = std::vector<std::uint8_t>(kSide, 1);
  int count_ = 0;
};

}  // namespace

HalftoneMask::HalftoneMask(std::uint64_t seed) : rank_(Filling(seed).Ranks()) {}

}  // namespace intaglio::discretize
