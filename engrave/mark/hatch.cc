// In a frame turned back by the angle the lines are y = y_k. An edge from a to b crosses
// them where min(a_y, b_y) <= y_k < max(a_y, b_y), at one x each; so a corner on a line
// counts once, and horizontal edges not at all. Along a line the crossings in order of x
// change the winding number by the direction of their edges, and what lies between two
// is inside by the rule.

#include "engrave/mark/hatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"

namespace intaglio::mark {
namespace {

// Shorter chords are rounding of a corner that a line touches.
constexpr double kMinChordMm = 1e-6;

struct Crossing {
  double x_mm;
  int turn;  // of the winding number, from left to right
};

class HatchLines {
 public:
  HatchLines(const HatchOptions& options, double angle_rad)
      : options_(options), cos_(std::cos(angle_rad)), sin_(std::sin(angle_rad)) {}

  Status Add(std::span<const std::vector<Vec2>> contours, std::vector<Chord>& chords) {
    INTAGLIO_TRY(Place(contours));
    for (const std::vector<Vec2>& contour : contours) {
      if (contour.size() < 3) continue;
      for (std::size_t i = 0; i < contour.size(); ++i)
        AddEdge(Turned(contour[i]), Turned(contour[(i + 1) % contour.size()]));
    }
    for (std::size_t k = 0; k < lines_.size(); ++k) INTAGLIO_TRY(AddChords(k, chords));
    return {};
  }

 private:
  Vec2 Turned(const Vec2& p) const {
    return {cos_ * p.x() + sin_ * p.y(), cos_ * p.y() - sin_ * p.x()};
  }
  Vec2 TurnedBack(double x, double y) const {
    return {cos_ * x - sin_ * y, sin_ * x + cos_ * y};
  }
  double HeightOf(double line) const { return first_mm_ + line * options_.distance_mm; }

  /// How many lines there are, and where.
  Status Place(std::span<const std::vector<Vec2>> contours) {
    double low_mm = std::numeric_limits<double>::infinity(), high_mm = -low_mm;
    for (const std::vector<Vec2>& contour : contours) {
      if (contour.size() < 3) continue;
      for (const Vec2& p : contour) {
        low_mm = std::min(low_mm, Turned(p).y());
        high_mm = std::max(high_mm, Turned(p).y());
      }
    }
    if (!(high_mm > low_mm)) return {};
    const double fit = std::floor((high_mm - low_mm) / options_.distance_mm + 1e-9);
    const double count = std::max(1.0, fit);
    if (count > static_cast<double>(kMaxChords)) return TooMany();
    first_mm_ = (low_mm + high_mm - (count - 1) * options_.distance_mm) / 2;
    lines_.resize(static_cast<std::size_t>(count));
    return {};
  }

  void AddEdge(const Vec2& a, const Vec2& b) {
    const double low = std::min(a.y(), b.y()), high = std::max(a.y(), b.y());
    if (lines_.empty() || low == high) return;
    double k = std::ceil((low - first_mm_) / options_.distance_mm) - 1;
    for (k = std::max(k, 0.0); k < static_cast<double>(lines_.size()); ++k) {
      const double y = HeightOf(k);
      if (y < low) continue;
      if (y >= high) break;
      const double x = a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y()));
      lines_[static_cast<std::size_t>(k)].push_back({x, b.y() > a.y() ? 1 : -1});
    }
  }

  bool IsInside(int winding, std::size_t crossed) const {
    return options_.rule == InsideRule::kEvenOdd ? crossed % 2 == 1 : winding != 0;
  }

  Status AddChords(std::size_t line, std::vector<Chord>& chords) const {
    std::vector<Crossing> crossings = lines_[line];
    std::ranges::sort(crossings, {}, &Crossing::x_mm);
    const std::size_t begin = chords.size();
    const double y = HeightOf(static_cast<double>(line));
    double from = 0, to = 0;
    bool open = false;
    const auto end_chord = [&] {
      const double inset = options_.inset_mm;
      if (open && to - from - 2 * inset > kMinChordMm)
        chords.push_back({TurnedBack(from + inset, y), TurnedBack(to - inset, y)});
      open = false;
    };
    int winding = 0;
    for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
      winding += crossings[i].turn;
      if (!IsInside(winding, i + 1)) continue;
      // Contours that share an edge are one area.
      if (open && crossings[i].x_mm - to > kMinChordMm) end_chord();
      if (!open) from = crossings[i].x_mm;
      to = crossings[i + 1].x_mm;
      open = true;
    }
    end_chord();
    if (chords.size() > kMaxChords) return TooMany();
    if (options_.bidirectional && line % 2 == 1) TurnBack(chords, begin);
    return {};
  }

  static void TurnBack(std::vector<Chord>& chords, std::size_t begin) {
    const auto first = chords.begin() + static_cast<std::ptrdiff_t>(begin);
    std::reverse(first, chords.end());
    for (auto chord = first; chord != chords.end(); ++chord)
      std::swap(chord->from_mm, chord->to_mm);
  }

  Status TooMany() const {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("hatching at a distance of {} mm takes more than {} lines; "
                            "use a larger distance",
                            options_.distance_mm, kMaxChords),
                fmt::format("{}", options_.distance_mm));
  }

  const HatchOptions& options_;
  double cos_, sin_;
  double first_mm_ = 0;
  std::vector<std::vector<Crossing>> lines_;
};

Status CheckHatch(std::span<const std::vector<Vec2>> contours,
                  const HatchOptions& options) {
  const auto wrong = [](const char* name, double value) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("hatching: {} is {}, out of its range", name, value),
                fmt::format("{}", value));
  };
  if (!(options.distance_mm > 0) || !std::isfinite(options.distance_mm))
    return wrong("distance_mm", options.distance_mm);
  if (!std::isfinite(options.angle_rad)) return wrong("angle_rad", options.angle_rad);
  if (!(options.inset_mm >= 0) || !std::isfinite(options.inset_mm))
    return wrong("inset_mm", options.inset_mm);
  for (const std::vector<Vec2>& contour : contours)
    for (const Vec2& p : contour)
      if (!p.allFinite()) return wrong("a place", p.sum());
  return {};
}

}  // namespace

Result<std::vector<Chord>> Hatch(std::span<const std::vector<Vec2>> contours,
                                 const HatchOptions& options) {
  INTAGLIO_TRY(CheckHatch(contours, options));
  std::vector<Chord> chords;
  INTAGLIO_TRY(HatchLines(options, options.angle_rad).Add(contours, chords));
  if (options.cross) {
    constexpr double kRightAngle = 1.5707963267948966;
    INTAGLIO_TRY(
        HatchLines(options, options.angle_rad + kRightAngle).Add(contours, chords));
  }
  return chords;
}

}  // namespace intaglio::mark
