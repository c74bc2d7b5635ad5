#include "engrave/calibrate/mark_matching.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "engrave/calibrate/median.h"
#include "engrave/core/counted.h"

// Every half degree, shifted so that the medians coincide, and as it is; the candidates
// with most marks near one are refined with the similarity of least squares of their
// pairs (as complex numbers: place = a + b measured), in ever smaller reach.

namespace intaglio::calibrate {
namespace {

using Complex = std::complex<double>;
constexpr double kDegree = std::numbers::pi / 180;
constexpr int kTurns = 720;
constexpr std::size_t kRefined = 12;
constexpr int kRounds = 12;

Complex Of(const Vec2& p) { return {p.x(), p.y()}; }

/// place = shift + turn * measured.
struct Similarity {
  Complex shift{0, 0}, turn{1, 0};
  Complex At(const Vec2& p) const { return shift + turn * Of(p); }
};

/// The marks in cells of `reach`, for the nearest one within it.
class Cells {
 public:
  Cells(const std::vector<Vec2>& marks_mm, double reach_mm)
      : marks_mm_(marks_mm), reach_mm_(reach_mm) {
    for (std::size_t i = 0; i < marks_mm.size(); ++i) {
      cells_[CellOf(Of(marks_mm[i]), 0, 0)].push_back(static_cast<int>(i));
    }
  }
  int Nearest(Complex at) const {
    int nearest = -1;
    double distance = reach_mm_;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto cell = cells_.find(CellOf(at, dx, dy));
        if (cell == cells_.end()) continue;
        for (const int i : cell->second) {
          const double d = std::abs(Of(marks_mm_[static_cast<std::size_t>(i)]) - at);
          if (d <= distance) nearest = i, distance = d;
        }
      }
    }
    return nearest;
  }

 private:
  std::int64_t CellOf(Complex at, int dx, int dy) const {
    const auto x = static_cast<std::int64_t>(std::floor(at.real() / reach_mm_)) + dx;
    const auto y = static_cast<std::int64_t>(std::floor(at.imag() / reach_mm_)) + dy;
    return (x << 32) ^ (y & 0xffffffff);
  }
  const std::vector<Vec2>& marks_mm_;
  double reach_mm_;
  std::unordered_map<std::int64_t, std::vector<int>> cells_;
};

Complex MedianPlaceOf(const std::vector<Vec2>& points, Complex turn) {
  std::vector<double> x, y;
  for (const Vec2& p : points) {
    const Complex at = turn * Of(p);
    x.push_back(at.real());
    y.push_back(at.imag());
  }
  return {MedianOf(x), MedianOf(y)};
}

int CountNear(const Cells& cells, const std::vector<Vec2>& measured,
              const Similarity& s) {
  return static_cast<int>(std::ranges::count_if(
      measured, [&](const Vec2& p) { return cells.Nearest(s.At(p)) >= 0; }));
}

/// Pairs of nearest marks, each mark once: with the measured mark nearest to it.
std::vector<int> PairsOf(const Cells& cells, const std::vector<Vec2>& marks,
                         const std::vector<Vec2>& measured, const Similarity& s) {
  std::vector<int> pairs(measured.size(), -1), taken(marks.size(), -1);
  const auto distance = [&](int mark, int of) {
    return std::abs(Of(marks[static_cast<std::size_t>(mark)]) -
                    s.At(measured[static_cast<std::size_t>(of)]));
  };
  for (int m = 0; m < static_cast<int>(measured.size()); ++m) {
    const int mark = cells.Nearest(s.At(measured[static_cast<std::size_t>(m)]));
    if (mark < 0) continue;
    int& other = taken[static_cast<std::size_t>(mark)];
    if (other >= 0 && distance(mark, other) <= distance(mark, m)) continue;
    if (other >= 0) pairs[static_cast<std::size_t>(other)] = -1;
    other = m;
    pairs[static_cast<std::size_t>(m)] = mark;
  }
  return pairs;
}

Similarity Fit(const std::vector<int>& pairs, const std::vector<Vec2>& marks,
               const std::vector<Vec2>& measured, double max_scale_error) {
  Complex mean_mark = 0, mean_measured = 0;
  double count = 0;
  const auto each = [&](const auto& take) {
    for (std::size_t m = 0; m < pairs.size(); ++m) {
      if (pairs[m] >= 0)
        take(Of(marks[static_cast<std::size_t>(pairs[m])]), Of(measured[m]));
    }
  };
  each([&](Complex mark, Complex at) {
    mean_mark += mark, mean_measured += at, count += 1;
  });
  mean_mark /= count, mean_measured /= count;
  Complex product = 0;
  double square = 0;
  each([&](Complex mark, Complex at) {
    product += (mark - mean_mark) * std::conj(at - mean_measured);
    square += std::norm(at - mean_measured);
  });
  Similarity s;
  s.turn = square > 0 ? product / square : Complex(1, 0);
  const double scale = std::abs(s.turn);
  if (scale > 0) {
    s.turn *= std::clamp(scale, 1 - max_scale_error, 1 + max_scale_error) / scale;
  }
  s.shift = mean_mark - s.turn * mean_measured;
  return s;
}

std::vector<Similarity> Candidates(const std::vector<Vec2>& marks,
                                   const std::vector<Vec2>& measured,
                                   const Cells& cells) {
  std::vector<Similarity> all = {{}};
  const Complex middle = MedianPlaceOf(marks, 1);
  for (int i = 0; i < kTurns; ++i) {
    const Complex turn = std::polar(1.0, i * 360 * kDegree / kTurns);
    all.push_back({middle - MedianPlaceOf(measured, turn), turn});
  }
  std::vector<std::pair<int, std::size_t>> counts;
  for (std::size_t i = 0; i < all.size(); ++i) {
    counts.emplace_back(-CountNear(cells, measured, all[i]), i);
  }
  std::sort(counts.begin() + 1, counts.end());  // as it is always counts
  std::vector<Similarity> best;
  for (std::size_t i = 0; i < std::min(kRefined, counts.size()); ++i) {
    best.push_back(all[counts[i].second]);
  }
  return best;
}

}  // namespace

Result<std::vector<int>> MatchMarks(const std::vector<Vec2>& marks_mm,
                                    const std::vector<Vec2>& measured_mm,
                                    const MatchOptions& options) {
  constexpr std::size_t kFewest = 20, kMany = 20000;
  if (measured_mm.size() < kFewest) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{} {} too few to recognize the pattern; measure {} "
                            "or more, or give their numbers",
                            Counted(measured_mm.size(), "mark"),
                            IsOrAre(measured_mm.size()), kFewest));
  }
  if (measured_mm.size() > std::min(kMany, 4 * marks_mm.size())) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{} marks are far more than the {} of the pattern; clean the "
                            "block, or cut the picture to the pattern",
                            measured_mm.size(), marks_mm.size()));
  }
  const double wide_mm = 4 * options.reach_mm;
  const Cells wide(marks_mm, wide_mm), near(marks_mm, options.reach_mm),
      middle(marks_mm, 2 * options.reach_mm);
  std::vector<int> best;
  std::ptrdiff_t best_count = -1;
  for (Similarity s : Candidates(marks_mm, measured_mm, wide)) {
    std::vector<int> pairs;
    for (int round = 0; round <= kRounds; ++round) {
      const Cells& cells = round < 4 ? wide : round < 8 ? middle : near;
      pairs = PairsOf(cells, marks_mm, measured_mm, s);
      if (std::ranges::count_if(pairs, [](int p) { return p >= 0; }) < 3) break;
      if (round < kRounds) s = Fit(pairs, marks_mm, measured_mm, options.max_scale_error);
    }
    const auto count = std::ranges::count_if(pairs, [](int p) { return p >= 0; });
    if (count > best_count) best = std::move(pairs), best_count = count;
  }
  const double needed = options.min_share * static_cast<double>(std::min(
                                                marks_mm.size(), measured_mm.size()));
  if (static_cast<double>(best_count) < needed) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the marks are not the pattern: at best {} of {} {} "
                            "within {} mm of one; check the unit or the pixel "
                            "size, and that it is seen from above",
                            best_count, Counted(measured_mm.size(), "measured mark"),
                            IsOrAre(best_count), options.reach_mm));
  }
  return best;
}

}  // namespace intaglio::calibrate
