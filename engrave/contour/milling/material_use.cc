#include "engrave/contour/milling/material_use.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/contour/simple_loops.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kWhite = 65535;

}  // namespace

Result<MaterialUse> MaterialUseOf(const std::vector<Edges>& loops) {
  const Region region = INTAGLIO_TRY(RegionOfLoops(loops));
  MaterialUse use;
  std::uint32_t sheet_count = 0;
  for (std::uint32_t k = 0; k < region.loops.size(); ++k) {
    const double area = std::abs(AreaOf(region.loops[k]));
    int nesting = 0;
    for (std::uint32_t other = 0; other < region.loops.size(); ++other) {
      if (other != k && IsInLoops(region.loops[other], region.loops[k].front().begin_mm))
        ++nesting;
    }
    if (nesting == 0) {
      ++sheet_count;
      use.sheet_mm2 = area;
    } else if (nesting % 2 == 1) {
      ++use.part_count;
      use.parts_mm2 += area;
    } else {
      ++use.hole_count;
      use.holes_mm2 += area;
    }
  }
  if (sheet_count != 1)
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} {} outermost, expected one, the sheet's around "
                            "all parts; draw it",
                            Counted(sheet_count, "contour"), IsOrAre(sheet_count)));
  use.used_mm2 = use.parts_mm2 - use.holes_mm2;
  use.use_percent = 100 * use.used_mm2 / use.sheet_mm2;
  return use;
}

Result<MaterialUse> MaterialUseOf(std::span<const std::uint16_t> brightness,
                                  double pixels_per_mm) {
  if (brightness.empty() || !(pixels_per_mm > 0))
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a picture of {} pixels with {} pixels per mm has no area",
                            brightness.size(), pixels_per_mm));
  double dark = 0;
  for (const std::uint16_t sample : brightness) dark += 1 - sample / kWhite;
  MaterialUse use;
  const double pixel_mm2 = 1 / (pixels_per_mm * pixels_per_mm);
  use.sheet_mm2 = static_cast<double>(brightness.size()) * pixel_mm2;
  use.used_mm2 = dark * pixel_mm2;
  use.parts_mm2 = use.used_mm2;
  use.use_percent = 100 * use.used_mm2 / use.sheet_mm2;
  return use;
}

}  // namespace intaglio::contour
