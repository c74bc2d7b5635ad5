#include "tests/engrave/motion/published_steps.h"

#include <algorithm>
#include <cmath>

#include "engrave/motion/axis/profile.h"

// Minimizes |A p - t|^2 over p >= 0 with sum p = 1, A the times of all rows when all
// steps have one length. Share is moved from one length to another, as much as lowers the
// sum the furthest, until no move does: the slope g = A^T (A p - t) is then the same for
// all lengths that have a share, and higher for all others (the conditions of Karush,
// Kuhn and Tucker). The problem is convex, so that there is no other minimum.

namespace intaglio::motion {
namespace {

constexpr double kPoints = 16179;
constexpr double kMaxDistance_mm = 15;
constexpr double kGrowth = 1.03;
constexpr int kMaxMoves = 20000;

using Columns = std::vector<std::vector<double>>;

double Dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

struct Move {
  std::size_t from = 0, to = 0;
  double share = 0, gain = 0;
};

Move BestMove(const Columns& products, const std::vector<double>& slopes,
              const std::vector<double>& shares) {
  const auto to = static_cast<std::size_t>(
      std::min_element(slopes.begin(), slopes.end()) - slopes.begin());
  Move best;
  for (std::size_t from = 0; from < shares.size(); ++from) {
    const double fall = slopes[from] - slopes[to];
    if (shares[from] <= 0 || fall <= 0) continue;
    const double bend = products[from][from] + products[to][to] - 2 * products[from][to];
    if (bend <= 0 || fall * fall / bend <= best.gain) continue;
    best = {from, to, std::min(shares[from], fall / bend), fall * fall / bend};
  }
  return best;
}

std::vector<double> SharesOf(const Columns& columns, const std::vector<double>& times) {
  const std::size_t count = columns.size();
  Columns products(count, std::vector<double>(count));
  std::vector<double> shares(count, 1.0 / static_cast<double>(count)), slopes(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) products[i][j] = Dot(columns[i], columns[j]);
    slopes[i] = Dot(products[i], shares) - Dot(columns[i], times);
  }
  for (int k = 0; k < kMaxMoves; ++k) {
    const Move move = BestMove(products, slopes, shares);
    if (move.gain < 1e-9) break;
    shares[move.from] -= move.share;
    shares[move.to] += move.share;
    for (std::size_t i = 0; i < count; ++i)
      slopes[i] += move.share * (products[i][move.to] - products[i][move.from]);
  }
  return shares;
}

}  // namespace

double SecondsOf(const StepModel& model, double distance_mm, const MeasuredTime& row) {
  double step_s = StopAndGoSeconds(distance_mm, {row.speed_mm_s, row.acceleration_mm_s2});
  // What is left of the way while it brakes is a t^2 / 2, t before the end.
  step_s -= std::min(step_s / 2, std::sqrt(2 * model.window_mm / row.acceleration_mm_s2));
  step_s += model.settling_s;
  if (model.cycle_s > 0)
    step_s = std::ceil(step_s / model.cycle_s - 1e-9) * model.cycle_s;
  if (!model.whole_ticks) return std::max(step_s, 1 / row.rate_hz);
  return static_cast<double>(WholeTicks(step_s, row.rate_hz)) / row.rate_hz;
}

StepFit FitSteps(const StepModel& model, double min_distance_mm,
                 const std::vector<MeasuredTime>& rows) {
  std::vector<double> distances_mm, times;
  for (double mm = min_distance_mm; mm < kMaxDistance_mm; mm *= kGrowth)
    distances_mm.push_back(mm);
  for (const MeasuredTime& row : rows) times.push_back(row.time_s);
  Columns columns;
  for (const double mm : distances_mm) {
    std::vector<double>& column = columns.emplace_back();
    for (const MeasuredTime& row : rows)
      column.push_back(kPoints * SecondsOf(model, mm, row));
  }
  const std::vector<double> shares = SharesOf(columns, times);
  StepFit fit;
  fit.difference_s.assign(rows.size(), 0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t j = 0; j < shares.size(); ++j)
      fit.difference_s[r] += shares[j] * columns[j][r];
    fit.difference_s[r] -= times[r];
    fit.largest_s = std::max(fit.largest_s, std::abs(fit.difference_s[r]));
  }
  fit.rms_s = std::sqrt(Dot(fit.difference_s, fit.difference_s) /
                        static_cast<double>(rows.size()));
  for (std::size_t j = 0; j < shares.size(); ++j)
    if (shares[j] > 0) fit.steps.push_back({distances_mm[j], shares[j]});
  return fit;
}

}  // namespace intaglio::motion
