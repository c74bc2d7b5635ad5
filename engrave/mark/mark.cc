#include "engrave/mark/mark.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"

namespace intaglio::mark {
namespace {

// Rounding of a row's places, when it is turned and moved.
constexpr double kStraightMm = 1e-6;

/// The way from one place to the next.
struct Way {
  Vec2 from_mm, to_mm;
  double bulge;
  bool dark;

  double chord_mm() const { return (to_mm - from_mm).norm(); }
  double sweep_rad() const { return 4 * std::atan(bulge); }
  double radius_mm() const {
    return chord_mm() / (2 * std::sin(std::abs(sweep_rad()) / 2));
  }
  double length_mm() const {
    return bulge == 0 ? chord_mm() : radius_mm() * std::abs(sweep_rad());
  }
};

template <typename Visit>
void ForEachWay(const Mark& mark, Visit visit) {
  const std::size_t count = mark.places.size();
  if (count < 2) return;
  for (std::size_t i = 0; i + 1 < count; ++i)
    visit(Way{mark.places[i].at_mm, mark.places[i + 1].at_mm, mark.places[i].bulge,
              mark.places[i].dark});
  if (mark.closed)
    visit(Way{mark.places.back().at_mm, mark.places.front().at_mm,
              mark.places.back().bulge, mark.places.back().dark});
}

void AppendChords(const Way& way, double tolerance_mm, std::vector<Vec2>& places) {
  places.push_back(way.from_mm);
  if (way.bulge == 0 || way.chord_mm() == 0) return;
  const double radius_mm = way.radius_mm(), sweep_rad = way.sweep_rad();
  const double largest_rad =
      2 * std::acos(std::max(0.0, 1 - std::min(1.0, tolerance_mm / radius_mm)));
  const int count = static_cast<int>(std::ceil(std::abs(sweep_rad) / largest_rad));
  const Vec2 chord = way.to_mm - way.from_mm;
  // The centre lies to the left of the chord, by the cotangent of half of the sweep.
  const Vec2 centre = way.from_mm + chord / 2 +
                      Vec2(-chord.y(), chord.x()) / (2 * std::tan(sweep_rad / 2));
  const Vec2 arm = way.from_mm - centre;
  for (int i = 1; i < count; ++i) {
    const double turn = sweep_rad * i / count;
    places.emplace_back(centre +
                        Vec2(arm.x() * std::cos(turn) - arm.y() * std::sin(turn),
                             arm.x() * std::sin(turn) + arm.y() * std::cos(turn)));
  }
}

Status Refuse(const std::string& name, const char* what, double value) {
  return Fail(ErrorCode::kInvalidValue, name + ": " + what, std::to_string(value));
}

Status CheckPen(const Pen& pen, const std::string& name) {
  if (!(pen.speed_mm_s > 0) || !std::isfinite(pen.speed_mm_s))
    return Refuse(name, "its speed is not above 0", pen.speed_mm_s);
  if (!(pen.power_ratio >= 0 && pen.power_ratio <= 1))
    return Refuse(name, "its power is outside 0..1", pen.power_ratio);
  if (!(pen.frequency_hz >= 0) || !std::isfinite(pen.frequency_hz))
    return Refuse(name, "its frequency is below 0", pen.frequency_hz);
  if (pen.pass_count == 0) return Refuse(name, "it makes no pass", 0);
  if (!(pen.depth_mm >= 0) || !std::isfinite(pen.depth_mm))
    return Refuse(name, "its depth is below 0", pen.depth_mm);
  if (pen.depth_mm > 0 && !(pen.plunge_mm_s > 0))
    return Refuse(name, "it has a depth and no plunge speed", pen.plunge_mm_s);
  return {};
}

/// Every place lies on the line from the first to the last, none before the one before
/// it.
bool GoesStraight(const Mark& mark) {
  const Vec2& from_mm = mark.places.front().at_mm;
  const Vec2 way = mark.places.back().at_mm - from_mm;
  if (!(way.norm() > 0)) return false;
  const Vec2 along = way.normalized();
  double before_mm = 0;
  for (const Place& place : mark.places) {
    const Vec2 to = place.at_mm - from_mm;
    const double along_mm = to.dot(along);
    if (place.bulge != 0 || (to - along_mm * along).norm() > kStraightMm) return false;
    if (along_mm < before_mm - kStraightMm) return false;
    before_mm = along_mm;
  }
  return true;
}

Status CheckRow(const Mark& mark, const std::string& name) {
  const auto count = static_cast<double>(mark.places.size());
  if (mark.closed) return Refuse(name, "it is closed and has a dark way", count);
  if (mark.places.front().dark || mark.places.back().dark ||
      mark.places[mark.places.size() - 2].dark)
    return Refuse(name, "it begins or ends with a dark way", count);
  for (std::size_t i = 1; i < mark.places.size(); ++i)
    if (mark.places[i].dark && mark.places[i - 1].dark)
      return Refuse(name, "two of its ways are dark, one behind the other", count);
  if (!GoesStraight(mark))
    return Refuse(name, "it has a dark way and does not go straight on", count);
  return {};
}

Status CheckMark(const Mark& mark, std::size_t pen_count, const std::string& name) {
  if (mark.pen >= pen_count) return Refuse(name, "it has no pen", mark.pen);
  if (mark.places.empty()) return Refuse(name, "it has no place", 0);
  bool finite = std::isfinite(mark.web_mm);
  for (const Place& place : mark.places)
    finite = finite && place.at_mm.allFinite() && std::isfinite(place.bulge);
  if (!finite) return Refuse(name, "a value is not finite", mark.web_mm);
  return IsRow(mark) ? CheckRow(mark, name) : Status();
}

}  // namespace

bool IsRow(const Mark& mark) { return std::ranges::any_of(mark.places, &Place::dark); }

double LitLengthOf(const Mark& mark) {
  double length_mm = 0;
  ForEachWay(mark, [&](const Way& way) { length_mm += way.dark ? 0 : way.length_mm(); });
  return length_mm;
}

std::vector<std::vector<Vec2>> LitWaysOf(const Mark& mark, double tolerance_mm) {
  std::vector<std::vector<Vec2>> ways;
  if (!IsRow(mark)) {
    ways.push_back(PlacesOf(mark, tolerance_mm));
    if (mark.closed && ways.front().size() > 1)
      ways.front().push_back(ways.front().front());
    return ways;
  }
  bool was_dark = true;
  for (const Place& place : mark.places) {
    if (was_dark) ways.emplace_back();
    ways.back().push_back(place.at_mm);
    was_dark = place.dark;
  }
  return ways;
}

std::size_t LitWayCount(const Mark& mark) {
  return 1 + static_cast<std::size_t>(std::ranges::count_if(mark.places, &Place::dark));
}

double LengthOf(const Mark& mark) {
  double length_mm = 0;
  ForEachWay(mark, [&](const Way& way) { length_mm += way.length_mm(); });
  return length_mm;
}

std::vector<Vec2> PlacesOf(const Mark& mark, double tolerance_mm) {
  std::vector<Vec2> places;
  places.reserve(mark.places.size());
  const bool straight =
      mark.places.size() > 1 &&
      std::ranges::all_of(mark.places, [](const Place& p) { return p.bulge == 0; });
  if (straight) {
    for (const Place& place : mark.places) places.push_back(place.at_mm);
    return places;
  }
  ForEachWay(mark, [&](const Way& way) { AppendChords(way, tolerance_mm, places); });
  if (!mark.closed && !mark.places.empty()) places.push_back(mark.places.back().at_mm);
  return places;
}

Vec2 MiddleOf(std::span<const Vec2> way_mm) {
  Vec2 sum = Vec2::Zero();
  double length = 0;
  for (std::size_t i = 1; i < way_mm.size(); ++i) {
    const double part = (way_mm[i] - way_mm[i - 1]).norm();
    sum += part * (way_mm[i] + way_mm[i - 1]) / 2;
    length += part;
  }
  return length > 0 ? Vec2(sum / length) : way_mm.front();
}

Status CheckMarks(const MarkSet& set) {
  for (std::size_t i = 0; i < set.pens.size(); ++i)
    INTAGLIO_TRY(CheckPen(set.pens[i], "pen " + std::to_string(i)));
  for (std::size_t i = 0; i < set.marks.size(); ++i)
    INTAGLIO_TRY(CheckMark(set.marks[i], set.pens.size(), "mark " + std::to_string(i)));
  return {};
}

}  // namespace intaglio::mark
