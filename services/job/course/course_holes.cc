// Whether a slot touches copper: the distance of its middle line from the copper changes
// by no more than the way along the line. So a part of length 2 h whose middle is h or
// more beyond the reach touches nowhere, one whose middle is within it does, and others
// are halved.

#include "services/job/course/course_holes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "engrave/contour/area.h"
#include "engrave/contour/crossings.h"
#include "engrave/contour/gaps.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"

namespace intaglio {
namespace {

/// Widths of rings are exact to this: their holes end where their copper begins.
constexpr double kTouchesMm = 0.01;
/// Places that differ by rounding are not over each other.
constexpr double kOverMm = 0.001;
/// Parts of a slot are not halved below it.
constexpr double kShortestPartMm = 0.001;

/// A hole, whose middle has no length, or a slot.
struct Opening {
  contour::Edge middle;
  double width_mm = 0;
  std::uint32_t route = 0;  ///< slots of one route have one number, holes their own

  bool is_hole() const { return middle.length_mm == 0; }
};

/// Holes in front of slots.
std::vector<Opening> OpeningsOf(const DrilledFile& file) {
  std::vector<Opening> all;
  std::uint32_t route = 0;
  for (const contour::Hole& hole : file.holes)
    all.push_back(
        {contour::MakeLine(hole.center_mm, hole.center_mm), hole.diameter_mm, route++});
  for (const contour::Element& slot : file.slots) {
    Opening next{MiddleOfSlot(slot), WidthOfSlot_mm(slot), route};
    const bool goes_on =
        all.size() > file.holes.size() && next.width_mm == all.back().width_mm &&
        (next.middle.begin_mm - all.back().middle.end_mm).norm() < kOverMm;
    if (goes_on) next.route = all.back().route;
    all.push_back(next);
    ++route;
  }
  return all;
}

contour::FlatBox BoxOf(const Opening& opening) {
  const contour::EdgeBox box = contour::BoxOfEdge(opening.middle);
  const Vec2 reach = Vec2::Constant(opening.width_mm / 2 + kTouchesMm);
  return {box.min_mm - reach, box.max_mm + reach};
}

/// "holes", "slots" or "holes and slots", and their number.
std::string CountedOpenings(const DrilledFile& file) {
  if (file.slots.empty()) return Counted(file.holes.size(), "hole");
  if (file.holes.empty()) return Counted(file.slots.size(), "slot");
  return fmt::format("{} and {}", Counted(file.holes.size(), "hole"),
                     Counted(file.slots.size(), "slot"));
}

std::string TextOf(const std::vector<contour::FlatBox>& boxes) {
  contour::FlatBox all = boxes.front();
  for (const contour::FlatBox& box : boxes) {
    all.min_mm = all.min_mm.cwiseMin(box.min_mm);
    all.max_mm = all.max_mm.cwiseMax(box.max_mm);
  }
  return fmt::format("from ({:.4g}, {:.4g}) to ({:.4g}, {:.4g}) mm", all.min_mm.x(),
                     all.min_mm.y(), all.max_mm.x(), all.max_mm.y());
}

std::string PlaceOf(const Opening& opening) {
  const Vec2 &begin = opening.middle.begin_mm, &end = opening.middle.end_mm;
  if (opening.is_hole())
    return fmt::format("{:.4g} mm at ({:.4g}, {:.4g})", opening.width_mm, begin.x(),
                       begin.y());
  return fmt::format("a slot of {:.4g} mm from ({:.4g}, {:.4g}) to ({:.4g}, {:.4g})",
                     opening.width_mm, begin.x(), begin.y(), end.x(), end.y());
}

Warning HoleWarning(std::string text) {
  Warning warning = MakeWarning(WarningCode::kOther, std::move(text));
  warning.weight = WarningWeight::kWarning;
  return warning;
}

/// From `begin_mm` to `end_mm` along the middle.
bool PartTouches(const contour::Area& copper, const Opening& opening, double begin_mm,
                 double end_mm) {
  const double half_mm = (end_mm - begin_mm) / 2;
  const Vec2 place = opening.is_hole()
                         ? opening.middle.begin_mm
                         : contour::PointAt(opening.middle, begin_mm + half_mm);
  const double beyond_mm =
      contour::Depth(copper, place) - opening.width_mm / 2 - kTouchesMm;
  if (beyond_mm < 0) return true;
  if (beyond_mm >= half_mm || half_mm < kShortestPartMm) return false;
  return PartTouches(copper, opening, begin_mm, begin_mm + half_mm) ||
         PartTouches(copper, opening, begin_mm + half_mm, end_mm);
}

void AddHolesBeside(const DrilledFile& file, const std::vector<Opening>& openings,
                    const std::vector<contour::Area>& copper, Warnings& warnings) {
  std::vector<contour::FlatBox> boxes, of_copper;
  for (const Opening& opening : openings) boxes.push_back(BoxOf(opening));
  const std::vector<contour::FlatBox> of_holes = boxes;
  for (const contour::Area& area : copper) {
    of_copper.push_back({area.min_mm, area.max_mm});
    boxes.push_back(of_copper.back());
  }
  const std::size_t count = openings.size();
  std::vector<char> touches(count, 0);
  for (const contour::Pair& pair : contour::NearPairs(boxes, 0)) {
    if (pair.first >= count || pair.second < count || touches[pair.first] != 0) continue;
    const Opening& opening = openings[pair.first];
    touches[pair.first] =
        PartTouches(copper[pair.second - count], opening, 0, opening.middle.length_mm);
  }
  const auto beside = static_cast<std::size_t>(std::ranges::count(touches, 0));
  if (beside == 0) return;
  const auto first =
      static_cast<std::size_t>(std::ranges::find(touches, 0) - touches.begin());
  warnings.push_back(HoleWarning(fmt::format(
      "{}: {} of {} {} beside all copper, the first {}; {} reach {}, copper {}; "
      "where that is not meant, correct the unit, the digits or the zero of the file",
      file.name, beside, CountedOpenings(file), VerbFor(beside, "lies", "lie"),
      PlaceOf(openings[first]), file.holes.empty() ? "slots" : "holes", TextOf(of_holes),
      TextOf(of_copper))));
}

/// How far one reaches into the other; negative: they are apart.
double DepthOf(const Opening& a, const Opening& b) {
  const double both_mm = (a.width_mm + b.width_mm) / 2;
  if (a.is_hole()) return both_mm - contour::DistanceTo(b.middle, a.middle.begin_mm);
  if (b.is_hole()) return both_mm - contour::DistanceTo(a.middle, b.middle.begin_mm);
  std::vector<Vec2> crossings;
  contour::AppendCrossings(a.middle, b.middle, crossings);
  return crossings.empty() ? both_mm - contour::GapBetween(a.middle, b.middle).distance_mm
                           : both_mm;
}

void AddHolesOver(const DrilledFile& file, const std::vector<Opening>& openings,
                  Warnings& warnings) {
  std::vector<contour::FlatBox> boxes;
  for (const Opening& opening : openings) boxes.push_back(BoxOf(opening));
  std::uint64_t count = 0;
  contour::Pair first{UINT32_MAX, UINT32_MAX};
  double over_mm = 0;
  bool of_slots = false;
  for (const contour::Pair& pair : contour::NearPairs(boxes, 0)) {
    const Opening &a = openings[pair.first], &b = openings[pair.second];
    if (a.route == b.route) continue;
    const double depth_mm = DepthOf(a, b);
    if (depth_mm < kOverMm) continue;
    ++count;
    over_mm = std::max(over_mm, depth_mm);
    of_slots = of_slots || !a.is_hole() || !b.is_hole();
    if (std::pair(pair.second, pair.first) < std::pair(first.second, first.first))
      first = pair;
  }
  if (count == 0) return;
  warnings.push_back(HoleWarning(fmt::format(
      "{}: {} of holes{} {} over each other, by up to {:.3g} mm, the first {} and "
      "{}; a drill breaks there: drill one of them, or mill {}",
      file.name, Counted(count, "pair"), of_slots ? " and slots" : "",
      VerbFor(count, "lies", "lie"), over_mm, PlaceOf(openings[first.first]),
      PlaceOf(openings[first.second]), of_slots ? "the slots" : "a slot")));
}

}  // namespace

contour::Edge MiddleOfSlot(const contour::Element& slot) {
  if (const auto* track = std::get_if<contour::Track>(&slot.shape))
    return contour::MakeLine(track->begin_mm, track->end_mm);
  return std::get<contour::ArcTrack>(slot.shape).arc;
}

double WidthOfSlot_mm(const contour::Element& slot) {
  if (const auto* track = std::get_if<contour::Track>(&slot.shape))
    return track->width_mm;
  return std::get<contour::ArcTrack>(slot.shape).width_mm;
}

Result<Warnings> WarningsOfHoles(const std::vector<DrilledFile>& files,
                                 const std::vector<contour::Element>& copper) {
  Warnings warnings;
  std::vector<contour::Area> areas;
  if (!std::ranges::all_of(files, &DrilledFile::has_own_pads)) {
    const auto rounded = INTAGLIO_TRY(contour::Rounded(copper));
    for (std::uint32_t k = 0; k < rounded.size(); ++k)
      INTAGLIO_TRY(
          contour::AppendGrown(rounded[k], k, 0, contour::Corners::kRound, areas));
  }
  for (const DrilledFile& file : files) {
    const std::vector<Opening> openings = OpeningsOf(file);
    if (openings.empty()) continue;
    if (!file.has_own_pads && !areas.empty())
      AddHolesBeside(file, openings, areas, warnings);
    AddHolesOver(file, openings, warnings);
  }
  return warnings;
}

}  // namespace intaglio
