#include "engrave/proof/mark_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "engrave/proof/row_comparison.h"

namespace intaglio::proof {
namespace {

constexpr double kChordMm = 1e-4;
/// Errors of scale change the length, a lost or repeated pass does it by a whole way.
constexpr double kLengthShare = 0.1;
constexpr double kLengthEndsMm = 0.05;

using MarkTicks = std::vector<formats::BurntTick>;

double BurntLength(const MarkTicks& ticks) {
  double length = 0;
  for (const auto& tick : ticks) length += tick.way_mm.norm();
  return length;
}

Vec2 BurntMean(const MarkTicks& ticks, double length) {
  Vec2 sum = Vec2::Zero();
  for (const auto& tick : ticks)
    sum += (tick.place_mm - tick.way_mm / 2) *
           (length > 0 ? tick.way_mm.norm() / length
                       : 1 / static_cast<double>(ticks.size()));
  return sum;
}

double DistanceToChord(const Vec2& place, const Vec2& from, const Vec2& to) {
  const Vec2 way = to - from;
  const double square = way.squaredNorm();
  const double share =
      square > 0 ? std::clamp((place - from).dot(way) / square, 0.0, 1.0) : 0;
  return (place - from - share * way).norm();
}

double ShapeUm(const std::vector<Vec2>& way, const MarkTicks& ticks, const Vec2& offset) {
  double worst = 0;
  for (const auto& tick : ticks) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < way.size(); ++i)
      nearest =
          std::min(nearest, DistanceToChord(tick.place_mm - offset, way[i - 1], way[i]));
    worst = std::max(worst, nearest);
  }
  return 1e3 * worst;
}

/// Between the end of each stroke and the begin of the next, and around.
double GapUm(const MarkTicks& ticks) {
  const auto begin = [](const auto& tick) { return Vec2(tick.place_mm - tick.way_mm); };
  double worst = (begin(ticks.front()) - ticks.back().place_mm).norm();
  for (std::size_t i = 1; i < ticks.size(); ++i)
    worst = std::max(worst, (begin(ticks[i]) - ticks[i - 1].place_mm).norm());
  return 1e3 * worst;
}

/// Empty: the way is no circle within a micrometre.
std::optional<double> CircleDiameter(const std::vector<Vec2>& way, const Vec2& centre) {
  if (way.size() < 16) return std::nullopt;
  const double radius = (way.front() - centre).norm();
  for (const Vec2& place : way)
    if (std::abs((place - centre).norm() - radius) > 1e-3) return std::nullopt;
  return 2 * radius;
}

double BurntDiameter(const MarkTicks& ticks, const Vec2& centre, double length) {
  double radius = 0;
  for (const auto& tick : ticks)
    radius += (tick.place_mm - centre).norm() * tick.way_mm.norm() / length;
  return 2 * radius;
}

/// A closed one with its first place repeated; of a row its dots.
std::vector<std::vector<Vec2>> PlannedWays(const mark::Mark& mark) {
  auto ways = mark::LitWaysOf(mark, kChordMm);
  for (std::vector<Vec2>& way : ways)
    for (Vec2& place : way) place.x() -= mark.web_mm;
  return ways;
}

/// By lengths, of all of them.
Vec2 MiddleOfWays(const std::vector<std::vector<Vec2>>& ways, double length_mm) {
  if (ways.size() == 1 || length_mm <= 0) return mark::MiddleOf(ways.front());
  Vec2 sum = Vec2::Zero();
  for (const std::vector<Vec2>& way : ways)
    sum += (way.back() - way.front()).norm() / length_mm * mark::MiddleOf(way);
  return sum;
}

BurntMark CompareMark(const mark::Mark& planned, std::uint32_t pass_count,
                      const MarkTicks& ticks) {
  BurntMark burnt;
  if (ticks.empty()) return burnt;
  const auto ways = PlannedWays(planned);
  const auto& way = ways.front();
  const double planned_mm = mark::LitLengthOf(planned), burnt_mm = BurntLength(ticks);
  const Vec2 centre = MiddleOfWays(ways, planned_mm),
             burnt_centre = BurntMean(ticks, burnt_mm);
  burnt.offset_mm = burnt_centre - centre;
  if (planned_mm <= 0) {
    burnt.fate = BurntFate::kMade;
    return burnt;
  }
  burnt.pass_count = burnt_mm / planned_mm;
  if (ways.size() > 1) {
    const BurntRow row = CompareRow(ways, ticks, pass_count, burnt.offset_mm);
    burnt.fate = row.fate();
    burnt.shape_um = row.shape_um;
    burnt.wrong_dot_count = row.missed_count + row.incomplete_count + row.doubled_count;
  } else {
    burnt.fate = FateOf(burnt_mm, planned_mm, pass_count);
    burnt.shape_um = ShapeUm(way, ticks, burnt.offset_mm);
  }
  if (planned.closed) burnt.gap_um = GapUm(ticks);
  if (burnt_mm <= 0) return burnt;
  double energy_mj = 0;
  for (const auto& tick : ticks) energy_mj += tick.energy_mj;
  burnt.energy_mj_mm = energy_mj / burnt_mm;
  if (const auto diameter = planned.closed ? CircleDiameter(way, centre) : std::nullopt)
    burnt.diameter_um = 1e3 * (BurntDiameter(ticks, burnt_centre, burnt_mm) - *diameter);
  return burnt;
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Removes the median of the deviations along each run of the web.
void TakeWebOut(const std::vector<MarkTicks>& ticks, std::vector<BurntMark>& marks) {
  std::map<std::uint32_t, std::vector<double>> of_run;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i].fate == BurntFate::kMade)
      of_run[ticks[i].front().run].push_back(marks[i].offset_mm.x());
  std::map<std::uint32_t, double> medians;
  for (auto& [run, offsets] : of_run) medians[run] = MedianOf(std::move(offsets));
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (ticks[i].empty() || !medians.contains(ticks[i].front().run)) continue;
    marks[i].web_shift_mm = medians[ticks[i].front().run];
    marks[i].offset_mm.x() -= marks[i].web_shift_mm;
  }
}

/// Lays each repeat upon the print mark that is nearest to the first of its marks.
std::uint64_t LayUponPrints(const mark::MarkSet& set, const PrintedRepeats& repeats,
                            std::vector<BurntMark>& marks) {
  std::map<std::int64_t, double> print_of;     // by repeat
  std::map<double, std::uint64_t> repeats_at;  // by print mark
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i].fate == BurntFate::kMissed || repeats.prints_mm.empty()) continue;
    const double web_mm = set.marks[i].web_mm;
    // Where its print mark would be, if it lay as planned.
    const double wanted_mm = marks[i].offset_mm.x() - web_mm - repeats.offset_mm;
    const auto [at, is_first] =
        print_of.try_emplace(std::llround(web_mm / repeats.pitch_mm), 0);
    if (is_first) {
      at->second = *std::ranges::min_element(
          repeats.prints_mm, {}, [&](double mm) { return std::abs(mm - wanted_mm); });
      ++repeats_at[at->second];
    }
    marks[i].web_shift_mm = at->second + repeats.offset_mm + web_mm;
    marks[i].offset_mm.x() -= marks[i].web_shift_mm;
  }
  std::uint64_t shared = 0;
  for (const auto& [print, count] : repeats_at) shared += count > 1 ? count : 0;
  return shared;
}

void Count(const mark::MarkSet& set, MarkComparison& result) {
  std::map<std::uint32_t, std::vector<double>> energies;
  for (std::size_t i = 0; i < result.marks.size(); ++i) {
    const BurntMark& burnt = result.marks[i];
    if (mark::IsRow(set.marks[i])) {
      const auto dots = mark::LitWayCount(set.marks[i]);
      result.dot_count += dots;
      result.wrong_dot_count +=
          burnt.fate == BurntFate::kMissed ? dots : burnt.wrong_dot_count;
    }
    result.missed_count += burnt.fate == BurntFate::kMissed;
    result.incomplete_count += burnt.fate == BurntFate::kIncomplete;
    result.doubled_count += burnt.fate == BurntFate::kDoubled;
    if (burnt.fate != BurntFate::kMade) continue;
    ++result.made_count;
    MarkErrors& worst = result.worst;
    worst.place_um = std::max(worst.place_um, 1e3 * burnt.offset_mm.norm());
    worst.shape_um = std::max(worst.shape_um, burnt.shape_um);
    worst.gap_um = std::max(worst.gap_um, burnt.gap_um.value_or(0));
    worst.diameter_um =
        std::max(worst.diameter_um, std::abs(burnt.diameter_um.value_or(0)));
    if (burnt.energy_mj_mm > 0) energies[set.marks[i].pen].push_back(burnt.energy_mj_mm);
  }
  for (const auto& [pen, values] : energies) {
    const double median = MedianOf(values);
    for (const double value : values)
      result.worst.energy_ratio =
          std::max(result.worst.energy_ratio, std::abs(value / median - 1));
  }
}

/// Compares each mark with its own ticks, which it returns.
std::vector<MarkTicks> TicksOfMarks(const mark::MarkSet& set,
                                    std::span<const formats::BurntTick> ticks,
                                    MarkComparison& result) {
  std::vector<MarkTicks> of_mark(set.marks.size());
  for (const auto& tick : ticks) {
    if (tick.mark < of_mark.size())
      of_mark[tick.mark].push_back(tick);
    else
      ++result.stray_tick_count;
  }
  for (std::size_t i = 0; i < set.marks.size(); ++i)
    result.marks.push_back(
        CompareMark(set.marks[i], set.pens[set.marks[i].pen].pass_count, of_mark[i]));
  return of_mark;
}

}  // namespace

BurntFate FateOf(double burnt_mm, double way_mm, std::uint32_t pass_count) {
  const double planned_mm = pass_count * way_mm;
  const double permitted_mm =
      std::min(kLengthShare * planned_mm + kLengthEndsMm, way_mm / 2);
  if (burnt_mm < planned_mm - permitted_mm) return BurntFate::kIncomplete;
  if (burnt_mm > planned_mm + permitted_mm) return BurntFate::kDoubled;
  return BurntFate::kMade;
}

bool MarkComparison::IsGood(double tolerance_um) const {
  return made_count == marks.size() && stray_tick_count == 0 && shared_print_count == 0 &&
         std::max({worst.place_um, worst.shape_um, worst.gap_um, worst.diameter_um}) <=
             tolerance_um;
}

MarkComparison CompareMarks(const mark::MarkSet& set,
                            std::span<const formats::BurntTick> ticks, bool on_web) {
  MarkComparison result;
  const auto of_mark = TicksOfMarks(set, ticks, result);
  if (on_web) TakeWebOut(of_mark, result.marks);
  Count(set, result);
  return result;
}

MarkComparison CompareMarks(const mark::MarkSet& set,
                            std::span<const formats::BurntTick> ticks,
                            const PrintedRepeats& repeats) {
  MarkComparison result;
  (void)TicksOfMarks(set, ticks, result);
  result.shared_print_count = LayUponPrints(set, repeats, result.marks);
  Count(set, result);
  return result;
}

}  // namespace intaglio::proof
