#include "services/job/course/course_slots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/contour/union.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/job/course/course_holes.h"

namespace intaglio {
namespace {

/// Widths within it are those of one tool.
constexpr double kSameWidth_mm = 0.001;
/// Of the diameter.
constexpr double kMaxCusp = 0.05;
constexpr std::size_t kMaxHoles = 1'000'000;

struct Slot {
  contour::Edge middle;  ///< of no length: a hole
  double width_mm = 0;
};

Slot SlotOf(const contour::Element& element) {
  return {MiddleOfSlot(element), WidthOfSlot_mm(element)};
}

double Cusp_mm(const Slot& slot, std::size_t parts) {
  const double half_mm = slot.width_mm / 2;
  const double pitch_mm = slot.middle.length_mm / static_cast<double>(parts);
  // A line is an arc whose sagitta is 0.
  double sagitta_mm = 0, half_chord_mm = pitch_mm / 2;
  if (slot.middle.is_arc()) {
    const double radius_mm = slot.middle.radius_mm;
    const double half_rad = half_chord_mm / radius_mm;
    half_chord_mm = radius_mm * std::sin(half_rad);
    sagitta_mm = radius_mm * (1 - std::cos(half_rad));
  }
  if (half_chord_mm >= half_mm) return half_mm + sagitta_mm;
  return half_mm + sagitta_mm -
         std::sqrt((half_mm - half_chord_mm) * (half_mm + half_chord_mm));
}

/// What is made of the slots of one file.
struct Made {
  std::size_t slots = 0, holes = 0;
  double min_width_mm = 1e300, max_width_mm = 0, max_cusp_mm = 0;

  void Count(double width_mm) {
    ++slots;
    min_width_mm = std::min(min_width_mm, width_mm);
    max_width_mm = std::max(max_width_mm, width_mm);
  }
  std::string Widths() const {
    if (max_width_mm - min_width_mm < kSameWidth_mm)
      return fmt::format("{:.4g} mm", min_width_mm);
    return fmt::format("{:.4g} to {:.4g} mm", min_width_mm, max_width_mm);
  }
};

/// So many that each hole between the ends can be in the middle of two that are drilled.
std::size_t BalancedParts(double parts) {
  if (parts <= 2) return static_cast<std::size_t>(std::ceil(parts));
  return 4 * static_cast<std::size_t>(std::ceil(parts / 4));
}

/// The drill wanders into a hole on one side of it, and not between two.
int TurnOf(std::size_t k, std::size_t parts) {
  if (k == 0 || k == parts) return 0;
  if (parts == 2 || k % 4 == 0) return 1;
  return k % 2 == 0 ? 2 : 3;
}

Status DrillSlot(const Slot& slot, Made& made, std::vector<contour::Hole>& holes) {
  const double length_mm = slot.middle.length_mm;
  double pitch_mm = 0.43 * slot.width_mm;  // below the bound of a line
  if (slot.width_mm <= 0 || length_mm / pitch_mm > static_cast<double>(kMaxHoles))
    return Fail(ErrorCode::kTooLarge,
                fmt::format("a slot of {:.4g} x {:.4g} mm needs more than {} holes; mill "
                            "it with --make curves",
                            slot.width_mm, length_mm, kMaxHoles));
  std::size_t parts = BalancedParts(length_mm / pitch_mm);
  while (parts > 0 && Cusp_mm(slot, parts) > kMaxCusp * slot.width_mm)
    parts = BalancedParts(static_cast<double>(parts) + 1);
  if (parts > 0) made.max_cusp_mm = std::max(made.max_cusp_mm, Cusp_mm(slot, parts));
  for (std::size_t k = 0; k <= parts; ++k) {
    const double way =
        k == parts ? length_mm
                   : length_mm * static_cast<double>(k) / static_cast<double>(parts);
    holes.push_back(
        {parts == 0 ? slot.middle.begin_mm : contour::PointAt(slot.middle, way),
         slot.width_mm, TurnOf(k, parts)});
  }
  // A ring ends where it begins.
  if (parts > 1 && (holes.back().center_mm - slot.middle.begin_mm).norm() < kSameWidth_mm)
    holes.pop_back();
  made.holes = holes.size();
  if (holes.size() <= kMaxHoles) return {};
  return Fail(ErrorCode::kTooLarge,
              fmt::format("the slots need more than {} holes; --make curves mills them",
                          kMaxHoles));
}

/// On the middle of a slot as wide as the tool, else along its wall.
Result<std::vector<contour::Edges>> MilledSlot(contour::Element element, const Slot& slot,
                                               double tool_mm) {
  const bool as_wide = slot.width_mm - tool_mm < kSameWidth_mm;
  if (as_wide && slot.middle.length_mm > kSameWidth_mm)
    return std::vector<contour::Edges>{{slot.middle}};
  const double left_mm = std::max(slot.width_mm - tool_mm, kSameWidth_mm);
  std::visit(
      [&](auto& shape) {
        if constexpr (requires { shape.width_mm; }) shape.width_mm = left_mm;
      },
      element.shape);
  std::vector<contour::Edges> paths;
  const auto wall =
      INTAGLIO_TRY(contour::Unite({&element, 1}, {0, contour::Corners::kRound}));
  for (const contour::Contour& contour : wall.contours) paths.push_back(contour.edges);
  return paths;
}

Warning LostSlots(const std::string& file, const Made& lost, const std::string& why) {
  Warning warning = MakeWarning(
      WarningCode::kOther,
      fmt::format("{}: {} of {} {} left out: {}", file, Counted(lost.slots, "slot"),
                  lost.Widths(), VerbFor(lost.slots, "is", "are"), why));
  warning.weight = WarningWeight::kWarning;
  return warning;
}

Status MillSlots(const Course& course, const std::string& file,
                 const std::vector<contour::Element>& slots, CourseFiles& files,
                 Warnings& warnings) {
  const double tool_mm = course.tool_diameter_mm();
  Made made, narrow;
  for (const contour::Element& element : slots) {
    const Slot slot = SlotOf(element);
    if (slot.width_mm - tool_mm < -kSameWidth_mm) {
      narrow.Count(slot.width_mm);
      continue;
    }
    made.Count(slot.width_mm);
    for (contour::Edges& path : INTAGLIO_TRY(MilledSlot(element, slot, tool_mm))) {
      const bool closed = (path.back().end_mm - path.front().begin_mm).norm() < 1e-6;
      files.curves.push_back(
          {fmt::format("{}, slot {}", file, made.slots), std::move(path), closed, true});
    }
  }
  if (made.slots > 0)
    warnings.push_back(MakeWarning(
        WarningCode::kChosen,
        fmt::format(
            "{}: {} of {} {} cut with the tool of {:.4g} mm, on {} middle where "
            "it is as wide, else along the wall, {:.4g} mm deep (course.depth_mm)",
            file, Counted(made.slots, "slot"), made.Widths(),
            VerbFor(made.slots, "is", "are"), tool_mm, made.slots == 1 ? "its" : "their",
            course.depth_mm())));
  if (narrow.slots > 0)
    warnings.push_back(LostSlots(
        file, narrow,
        fmt::format("the tool of {:.4g} mm is wider; use one of {:.4g} mm or less",
                    tool_mm, narrow.min_width_mm)));
  return {};
}

Status DrillSlots(const std::string& file, const std::vector<contour::Element>& slots,
                  CourseFiles& files, Warnings& warnings) {
  Made made;
  std::vector<contour::Hole> holes;
  for (const contour::Element& element : slots) {
    const Slot slot = SlotOf(element);
    made.Count(slot.width_mm);
    INTAGLIO_TRY(DrillSlot(slot, made, holes));
  }
  files.holes.insert(files.holes.end(), holes.begin(), holes.end());
  warnings.push_back(MakeWarning(
      WarningCode::kChosen,
      fmt::format("{}: {} of {} {} drilled as {} in a row, ends first and each other one "
                  "between two, which leave cusps of up to {:.3g} mm; a drill may still "
                  "run off in a hole beside: feed slowly, or mill them with --make "
                  "curves and a tool of {:.4g} mm or less",
                  file, Counted(made.slots, "slot"), made.Widths(),
                  VerbFor(made.slots, "is", "are"), Counted(made.holes, "hole"),
                  made.max_cusp_mm, made.min_width_mm)));
  return {};
}

}  // namespace

Status AddSlots(const Course& course, const std::string& file,
                const std::vector<contour::Element>& slots, CourseFiles& files,
                Warnings& warnings) {
  if (slots.empty()) return {};
  if (course.make() == COURSE_MAKE_CURVES)
    return MillSlots(course, file, slots, files, warnings);
  if (!course.has_power_ratio()) return DrillSlots(file, slots, files, warnings);
  Made lost;
  for (const contour::Element& element : slots) lost.Count(SlotOf(element).width_mm);
  warnings.push_back(
      LostSlots(file, lost, "a laser cuts them with --make curves (course.make)"));
  return {};
}

}  // namespace intaglio
