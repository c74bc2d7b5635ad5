#include "engrave/discretize/picture/halftone_screen.h"

#include <random>

namespace intaglio::discretize {

PanelPoints ScreenByMask(const HalftoneGrid& grid, const DensityOf& density,
                         const HalftoneMask& mask, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const int aside = static_cast<int>(random() % HalftoneMask::kSide);
  const int down = static_cast<int>(random() % (HalftoneMask::kSide / 2)) * 2;
  PanelPoints points;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const double share = density(grid.BrightnessAt(column, row));
      // The grid's even rows are shifted to the right of its odd ones, the mask's to the
      // left.
      if (!mask.Takes(column + aside, row + 1 + down, share)) continue;
      const Vec2 p_mm = grid.At(column, row);
      if (grid.Contains(p_mm)) points.push_back(p_mm);
    }
  }
  return points;
}

namespace {

/// One row after another from below, in serpentine order. The error of a place is
/// subtracted from its neighbours that are not yet decided: 7/16 from the next one, 3/16
/// (back), 5/16 and 1/16 from those in the next row. At a border the missing shares are
/// divided among the others, so no brightness is lost.
class ErrorDiffusion {
 public:
  ErrorDiffusion(int columns, std::uint64_t seed)
      : random_(seed), columns_(columns), here_(Size()), next_(Size()) {
    for (double& error : here_) error = Noise();  // else the first rows stay empty
  }

  template <typename Density, typename Take>
  void Row(bool forward, bool last, const Density& density, const Take& take) {
    const int step = forward ? 1 : -1;
    int column = forward ? 0 : columns_ - 1;
    for (int i = 0; i < columns_; ++i, column += step) {
      const double share = density(column);
      const double wanted = share + here_[Index(column)];
      // Black stays empty and white full, whatever error comes from neighbours.
      const bool taken = share >= 1 || (share > 0 && wanted > 0.5 + kNoise * Noise());
      if (taken) take(column);
      Spread(column, step, last, wanted - (taken ? 1 : 0));
    }
    std::swap(here_, next_);
    next_.assign(Size(), 0);
  }

 private:
  static constexpr double kNoise = 0.5;

  std::size_t Size() const { return static_cast<std::size_t>(columns_); }
  static std::size_t Index(int column) { return static_cast<std::size_t>(column); }
  /// -0.5 .. 0.5.
  double Noise() { return static_cast<double>(random_() >> 11) * 0x1p-53 - 0.5; }

  void Spread(int column, int step, bool last, double error) {
    const bool has_next = column + step >= 0 && column + step < columns_;
    const bool has_back = column - step >= 0 && column - step < columns_;
    const double ahead = has_next ? 7 : 0;
    const double back = has_back && !last ? 3 : 0, below = last ? 0 : 5;
    const double beyond = has_next && !last ? 1 : 0;
    const double sum = ahead + back + below + beyond;
    if (sum == 0) return;
    if (has_next) here_[Index(column + step)] += error * ahead / sum;
    if (has_back) next_[Index(column - step)] += error * back / sum;
    next_[Index(column)] += error * below / sum;
    if (has_next) next_[Index(column + step)] += error * beyond / sum;
  }

  std::mt19937_64 random_;
  int columns_;
  std::vector<double> here_, next_;
};

}  // namespace

PanelPoints ScreenByErrors(const HalftoneGrid& grid, const DensityOf& density,
                           std::uint64_t seed) {
  // Places outside the panel are left out; otherwise they would remove brightness.
  const auto inside = [&](int column, int row) {
    return grid.Contains(grid.At(column, row));
  };
  int left = 0, right = grid.columns, low = 0, high = grid.rows;
  while (left < right && !inside(left, 1)) ++left;
  while (right > left && !inside(right - 1, 1)) --right;
  while (low < high && !inside(left, low)) ++low;
  while (high > low && !inside(left, high - 1)) --high;
  PanelPoints points;
  if (left == right) return points;
  ErrorDiffusion diffusion(right - left, seed);
  for (int row = low; row < high; ++row) {
    diffusion.Row(
        row % 2 == 0, row + 1 == high,
        [&](int column) { return density(grid.BrightnessAt(left + column, row)); },
        [&](int column) { points.push_back(grid.At(left + column, row)); });
  }
  return points;
}

}  // namespace intaglio::discretize
