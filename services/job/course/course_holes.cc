#include "services/job/course/course_holes.h"

#include <fmt/format.h>

#include <cstdint>

#include "engrave/contour/area.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"

namespace intaglio {
namespace {

/// Widths of rings are exact to this: their holes end where their copper begins.
constexpr double kTouchesMm = 0.01;
/// Places that differ by rounding are not over each other.
constexpr double kOverMm = 0.001;

contour::FlatBox BoxOf(const contour::Hole& hole) {
  const Vec2 reach = Vec2::Constant(hole.diameter_mm / 2 + kTouchesMm);
  return {hole.center_mm - reach, hole.center_mm + reach};
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

std::string PlaceOf(const contour::Hole& hole) {
  return fmt::format("{:.4g} mm at ({:.4g}, {:.4g})", hole.diameter_mm,
                     hole.center_mm.x(), hole.center_mm.y());
}

Warning HoleWarning(std::string text) {
  Warning warning = MakeWarning(WarningCode::kOther, std::move(text));
  warning.weight = WarningWeight::kWarning;
  return warning;
}

void AddHolesBeside(const DrilledFile& file, const std::vector<contour::Area>& copper,
                    Warnings& warnings) {
  std::vector<contour::FlatBox> boxes, of_copper;
  for (const contour::Hole& hole : file.holes) boxes.push_back(BoxOf(hole));
  const std::vector<contour::FlatBox> of_holes = boxes;
  for (const contour::Area& area : copper) {
    of_copper.push_back({area.min_mm, area.max_mm});
    boxes.push_back(of_copper.back());
  }
  std::vector<char> touches(file.holes.size(), 0);
  for (const contour::Pair& pair : contour::NearPairs(boxes, 0)) {
    const std::size_t count = file.holes.size();
    if (pair.first >= count || pair.second < count || touches[pair.first] != 0) continue;
    const contour::Hole& hole = file.holes[pair.first];
    touches[pair.first] = contour::Depth(copper[pair.second - count], hole.center_mm) <
                          hole.diameter_mm / 2 + kTouchesMm;
  }
  std::size_t beside = 0, first = 0;
  for (std::size_t k = touches.size(); k-- > 0;) {
    if (touches[k] != 0) continue;
    ++beside;
    first = k;
  }
  if (beside == 0) return;
  warnings.push_back(HoleWarning(fmt::format(
      "{}: {} of {} {} beside all copper, the first {}; holes reach {}, copper "
      "{}; "
      "where that is not meant, correct the unit, the digits or the zero of the file",
      file.name, beside, Counted(file.holes.size(), "hole"),
      VerbFor(beside, "lies", "lie"), PlaceOf(file.holes[first]), TextOf(of_holes),
      TextOf(of_copper))));
}

void AddHolesOver(const DrilledFile& file, Warnings& warnings) {
  std::vector<contour::FlatBox> boxes;
  for (const contour::Hole& hole : file.holes) boxes.push_back(BoxOf(hole));
  std::uint64_t count = 0;
  contour::Pair first{UINT32_MAX, UINT32_MAX};
  double over_mm = 0;
  for (const contour::Pair& pair : contour::NearPairs(boxes, 0)) {
    const contour::Hole &a = file.holes[pair.first], &b = file.holes[pair.second];
    const double depth_mm =
        (a.diameter_mm + b.diameter_mm) / 2 - (a.center_mm - b.center_mm).norm();
    if (depth_mm < kOverMm) continue;
    ++count;
    over_mm = std::max(over_mm, depth_mm);
    if (pair.second < first.second) first = pair;
  }
  if (count == 0) return;
  warnings.push_back(HoleWarning(fmt::format(
      "{}: {} of holes {} over each other, by up to {:.3g} mm, the first {} and "
      "{}; a drill breaks there: drill one of them, or mill a slot",
      file.name, Counted(count, "pair"), VerbFor(count, "lies", "lie"), over_mm,
      PlaceOf(file.holes[first.first]), PlaceOf(file.holes[first.second]))));
}

}  // namespace

Result<Warnings> WarningsOfHoles(const std::vector<DrilledFile>& files,
                                 const std::vector<contour::Element>& copper) {
  Warnings warnings;
  std::vector<contour::Area> areas;
  if (!files.empty()) {
    const auto rounded = INTAGLIO_TRY(contour::Rounded(copper));
    for (std::uint32_t k = 0; k < rounded.size(); ++k)
      INTAGLIO_TRY(
          contour::AppendGrown(rounded[k], k, 0, contour::Corners::kRound, areas));
  }
  for (const DrilledFile& file : files) {
    if (!areas.empty() && !file.holes.empty()) AddHolesBeside(file, areas, warnings);
    AddHolesOver(file, warnings);
  }
  return warnings;
}

}  // namespace intaglio
