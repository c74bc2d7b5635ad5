#include "engrave/contour/isolation.h"

#include <fmt/format.h>

#include "engrave/contour/gaps.h"
#include "engrave/contour/option_range.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// A gap as wide as the tool but for the rounding of coordinates is wide enough.
constexpr double kRounding_mm = 2e-6;
constexpr std::size_t kMaxNamed = 5;

Status CheckOptions(const IsolationOptions& options) {
  INTAGLIO_TRY(CheckOption("the tool's diameter", options.tool_diameter_mm, 0.001, 100));
  INTAGLIO_TRY(CheckOption("the number of passes", options.pass_count, 1, 20));
  // Below one half slivers may remain: see the header.
  return CheckOption("the overlap of passes", options.overlap_ratio, 0.5, 0.95);
}

Status CheckGaps(std::span<const Element> elements, const Union& copper, double tool_mm) {
  const std::vector<Gap> gaps =
      INTAGLIO_TRY(NarrowGaps(elements, copper.groups, tool_mm - kRounding_mm));
  if (gaps.empty()) return {};
  std::string sentence;
  for (std::size_t k = 0; k < std::min(gaps.size(), kMaxNamed); ++k) {
    const Gap& gap = gaps[k];
    const auto name = [&](std::uint32_t e) {
      return elements[e].name.empty() ? Describe(elements[e]) : elements[e].name;
    };
    sentence += fmt::format(
        "{}cannot isolate {} from {}: gap {:.4g} < tool {:.4g} at ({:.4g}, {:.4g})",
        k == 0 ? "" : "; ", name(gap.first), name(gap.second), gap.width_mm, tool_mm,
        gap.place_mm.x(), gap.place_mm.y());
  }
  if (gaps.size() > kMaxNamed)
    sentence += fmt::format("; and {} more", gaps.size() - kMaxNamed);
  return Fail(
      ErrorCode::kUnsupported,
      sentence + fmt::format("; use a tool of {:.4g} mm or less, or move them apart",
                             gaps[0].width_mm),
      fmt::format("{:.6g}", gaps[0].width_mm));
}

}  // namespace

Result<Isolation> Isolate(std::span<const Element> elements,
                          const IsolationOptions& options) {
  INTAGLIO_TRY(CheckOptions(options));
  const std::vector<Element> rounded = INTAGLIO_TRY(Rounded(elements));
  const Union copper = INTAGLIO_TRY(Unite(rounded, {0, Corners::kRound}));
  INTAGLIO_TRY(CheckGaps(rounded, copper, options.tool_diameter_mm));
  const double radius = options.tool_diameter_mm / 2;
  const double step = options.tool_diameter_mm * (1 - options.overlap_ratio);
  Isolation isolation;
  isolation.net_count = copper.group_count;
  for (int k = 0; k < options.pass_count; ++k) {
    const double offset = radius + k * step;
    Union grown = INTAGLIO_TRY(Unite(rounded, {offset, Corners::kRound}));
    isolation.passes.push_back({offset, std::move(grown.contours)});
    isolation.width_mm = offset + radius;
  }
  return isolation;
}

}  // namespace intaglio::contour
