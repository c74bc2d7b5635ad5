#include "services/cli/contour/contour_figures.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"
#include "engrave/post/tab_parts.h"
#include "services/cli/contour/contour_programs.h"
#include "services/client/figure_text.h"
#include "services/job/convert/v_bit.h"

namespace intaglio::cli {
namespace {

// How far a sheet is from the height at which a V-shaped tool was zeroed, for its width.
constexpr double kUnevenMm = 0.05;

/// Sums over all passes of all paths.
struct PassSums {
  double work_mm = 0;
  double over_tabs_mm = 0;  ///< from part to part of a path
  double part_count = 0;
};

PassSums SumPasses(const ContourWork& work, const post::Cutting& cutting) {
  PassSums sums;
  for (const post::ToolPath& path : work.paths) {
    for (std::size_t pass = 0; pass < cutting.depths_mm.size(); ++pass) {
      contour::Edges edges;
      for (const post::PathPart& part : post::PartsOfPass(path, cutting, pass)) {
        if (!edges.empty())
          sums.over_tabs_mm += (part.path.begin_mm - edges.back().end_mm).norm();
        edges = post::EdgesOf(part.path);
        sums.work_mm += contour::LengthOf(edges);
        ++sums.part_count;
      }
    }
  }
  return sums;
}

}  // namespace

WorkTime TimeOf(const ContourWork& work, const Course& whole) {
  WorkTime time;
  const PassSums sums = SumPasses(work, MillingOf(whole, {}));
  time.work_s = sums.work_mm / whole.speed_mm_s();
  const double down_s = whole.safe_height_mm() / whole.travel_mm_s() +
                        (whole.safe_height_mm() + whole.depth_mm()) / whole.plunge_mm_s();
  const bool lifts = !whole.has_power_ratio();
  time.idle_s = (work.idle_mm + sums.over_tabs_mm) / whole.travel_mm_s() +
                (lifts ? sums.part_count * down_s : 0);
  const double hole_mm = whole.safe_height_mm() + whole.drill_depth_mm();
  time.drill_s = work.drill_idle_mm / whole.travel_mm_s() +
                 static_cast<double>(work.hole_count) * hole_mm *
                     (1 / whole.plunge_mm_s() + 1 / whole.travel_mm_s());
  return time;
}

std::vector<std::string> FiguresOf(const ContourWork& work, const Course& whole) {
  const auto saved = [](double mm, double of_mm) {
    return of_mm > 0 ? 100 * (1 - mm / of_mm) : 0;
  };
  std::vector<std::string> lines{fmt::format(
      "elements      {}, {} with {}", client::GroupedDigits(work.element_count),
      client::GroupedCount(work.hole_count, "hole"),
      Counted(work.rounds.size(), "tool"))};
  if (IsVBit(whole)) {
    lines.push_back(fmt::format(
        "tool          {:.4g} mm wide at {:g} mm depth, {:.4g} mm where it is {:g} mm "
        "deeper",
        whole.tool_diameter_mm(), whole.depth_mm(),
        WidthOfVBit(whole, whole.depth_mm() + kUnevenMm), kUnevenMm));
  }
  if (work.net_count) {
    lines.push_back(fmt::format("isolation     {}, {:.3g} mm around the copper",
                                client::GroupedCount(*work.net_count, "net"),
                                work.isolated_mm));
    lines.push_back(
        work.piece_count == *work.net_count
            ? fmt::format("pieces        {}, each net in one of its own",
                          client::GroupedDigits(work.piece_count))
            : fmt::format("pieces        {}, none with two nets; parts of one net that "
                          "lie nearer than the tool is wide stay together",
                          client::GroupedDigits(work.piece_count)));
  }
  if (work.proved_net_count) {
    lines.push_back(
        fmt::format("copper left   {} as the file has them, none short or open",
                    client::GroupedCount(*work.proved_net_count, "net")));
  }
  if (whole.make() == COURSE_MAKE_POCKET) {
    lines.push_back(fmt::format(
        "left over     {:.3g} mm2 in corners and necks narrower than the tool{}",
        work.left_mm2,
        work.left_at_wall_mm > 0 ? fmt::format(", and up to {:g} um along the walls",
                                               1000 * work.left_at_wall_mm)
                                 : ""));
  }
  const WorkTime time = TimeOf(work, whole);
  lines.push_back(fmt::format("contours      {}, {:.1f} mm at work, {}",
                              client::GroupedDigits(work.paths.size()), work.work_mm,
                              Counted(whole.repeat_count(), "time")));
  lines.push_back(fmt::format(
      "idle way      {:.1f} mm, {:.1f} % less than to the nearest "
      "contour; {:.1f} mm to the holes",
      work.idle_mm, saved(work.idle_mm, work.nearest_idle_mm), work.drill_idle_mm));
  lines.push_back(fmt::format(
      "time          {}: {} at work, {} between, {} drilling; without acceleration",
      client::ShortDuration(time.sum_s()), client::ShortDuration(time.work_s),
      client::ShortDuration(time.idle_s), client::ShortDuration(time.drill_s)));
  return lines;
}

}  // namespace intaglio::cli
