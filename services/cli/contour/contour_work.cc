#include "services/cli/contour/contour_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "engrave/contour/contour_order.h"
#include "engrave/contour/isolation.h"
#include "engrave/contour/union.h"
#include "engrave/core/try.h"
#include "engrave/post/tab_parts.h"
#include "services/cli/contour/contour_areas.h"
#include "services/cli/contour/contour_nets.h"
#include "services/client/figure_text.h"

namespace intaglio::cli {
namespace {

struct Contours {
  std::vector<contour::Contour> all;  ///< clockwise, as the published programs
  std::vector<int> passes;

  void Add(std::vector<contour::Contour> contours, int pass) {
    for (contour::Contour& contour : contours) {
      contour.edges = contour::Clockwise(contour);
      all.push_back(std::move(contour));
      passes.push_back(pass);
    }
  }
};

Status KeepCopper(std::span<const contour::Element> elements, contour::Corners corners,
                  ContourWork& work) {
  const auto copper = INTAGLIO_TRY(contour::Unite(elements, {0, corners}));
  for (const contour::Contour& contour : copper.contours)
    work.copper.push_back(contour.edges);
  return {};
}

Result<Contours> ContoursOf(const Course& course,
                            std::span<const contour::Element> elements,
                            const std::vector<DrawnNets>& boards, ContourWork& work) {
  Contours contours;
  if (elements.empty()) return contours;
  if (course.make() == COURSE_MAKE_ISOLATION) {
    auto made = INTAGLIO_TRY(contour::Isolate(
        elements, {course.tool_diameter_mm(), static_cast<int>(course.pass_count()),
                   course.overlap_ratio()}));
    INTAGLIO_TRY(KeepCopper(elements, contour::Corners::kRound, work));
    work.net_count = made.net_count;
    work.isolated_mm = made.width_mm;
    for (const DrawnNets& board : boards) {
      const auto report = INTAGLIO_TRY(ProveNets(board, made, course.tool_diameter_mm()));
      work.proved_net_count = work.proved_net_count.value_or(0) + report.net_count;
    }
    int pass = 0;
    for (contour::IsolationPass& row : made.passes)
      contours.Add(std::move(row.contours), pass++);
    return contours;
  }
  const contour::Corners corners =
      course.round_corners() ? contour::Corners::kRound : contour::Corners::kSharp;
  const auto rounded = INTAGLIO_TRY(contour::Rounded(elements));
  auto made =
      INTAGLIO_TRY(contour::Unite(rounded, {course.tool_diameter_mm() / 2, corners}));
  INTAGLIO_TRY(KeepCopper(rounded, corners, work));
  contours.Add(std::move(made.contours), 0);
  return contours;
}

void OrderContours(const Course& course, const Contours& contours, const Vec2& start_mm,
                   ContourWork& work) {
  auto visits = contour::NearestContours(contours.all, start_mm);
  work.nearest_idle_mm = contour::IdleWay_mm(contours.all, start_mm, visits);
  if (!course.nearest_order()) contour::ImproveContours(contours.all, start_mm, visits);
  work.idle_mm = contour::IdleWay_mm(contours.all, start_mm, visits);
  for (const contour::ContourVisit& visit : visits) {
    work.paths.push_back(
        post::PathOf(contour::EdgesFrom(contours.all[visit.contour].edges, visit),
                     fmt::format("contour {}", work.paths.size() + 1)));
    work.passes.push_back(contours.passes[visit.contour]);
    work.work_mm += contours.all[visit.contour].length_mm;
  }
}

/// Curves as they are, each from its begin.
void OrderCurves(const Course& course, const std::vector<DrawnCurve>& curves,
                 const Vec2& start_mm, ContourWork& work) {
  std::vector<Vec2> begins;
  for (const DrawnCurve& curve : curves) begins.push_back(curve.edges.front().begin_mm);
  const auto idle_mm = [&](const contour::VisitOrder& order) {
    double sum_mm = 0;
    Vec2 at_mm = start_mm;
    for (const std::uint32_t i : order) {
      sum_mm += (begins[i] - at_mm).norm();
      at_mm = curves[i].edges.back().end_mm;
    }
    return sum_mm;
  };
  contour::VisitOrder order = contour::NearestOrder(begins, start_mm);
  work.nearest_idle_mm = work.idle_mm = idle_mm(order);
  if (!course.nearest_order()) {
    contour::VisitOrder improved = order;
    contour::ImproveOrder(begins, start_mm, improved);
    // It measures from begin to begin: of open curves it may be the longer one.
    if (idle_mm(improved) < work.idle_mm) order = std::move(improved);
    work.idle_mm = idle_mm(order);
  }
  for (const std::uint32_t i : order) {
    work.paths.push_back(post::PathOf(curves[i].edges, curves[i].name));
    work.passes.push_back(0);
    work.work_mm += contour::LengthOf(curves[i].edges);
  }
}

/// Pockets and cuts: in the order in which they were made.
Status TakeAreas(const Course& course, const std::vector<contour::Element>& elements,
                 const Vec2& start_mm, ContourWork& work) {
  const AreaPaths made = INTAGLIO_TRY(course.make() == COURSE_MAKE_POCKET
                                          ? ClearAreas(course, elements, start_mm)
                                          : CutAreas(course, elements));
  INTAGLIO_TRY(KeepCopper(elements, contour::Corners::kRound, work));
  work.left_mm2 = made.left_mm2;
  Vec2 at_mm = start_mm;
  for (std::size_t i = 0; i < made.paths.size(); ++i) {
    const contour::Edges& edges = made.paths[i];
    work.idle_mm += (edges.front().begin_mm - at_mm).norm();
    at_mm = edges.back().end_mm;
    work.paths.push_back(
        post::PathOf(edges, fmt::format("contour {}", i + 1), 0,
                     made.tabs.empty() ? std::vector<bool>() : made.tabs[i]));
    work.passes.push_back(made.passes[i]);
    work.work_mm += contour::LengthOf(edges);
  }
  work.nearest_idle_mm = work.idle_mm;
  return {};
}

void PlanHoles(const Course& course, const std::vector<contour::Hole>& holes,
               const Vec2& start_mm, ContourWork& work) {
  const auto tools =
      contour::PlanDrilling(holes, start_mm,
                            course.nearest_order() ? contour::OrderKind::kNearest
                                                   : contour::OrderKind::kImproved);
  Vec2 at_mm = start_mm;
  for (const contour::DrillTool& tool : tools) {
    post::DrillRound round{tool.diameter_mm, {}};
    for (const std::uint32_t i : tool.holes) {
      round.places_mm.push_back(holes[i].center_mm);
      work.drill_idle_mm += (holes[i].center_mm - at_mm).norm();
      at_mm = holes[i].center_mm;
    }
    work.rounds.push_back(std::move(round));
  }
}

void GiveIf(bool given, const char* variable, post::Cutting& cutting) {
  if (given) cutting.given.emplace_back(variable);
}

post::Cutting CommonOf(const Course& whole, const Course& typed) {
  post::Cutting cutting;
  cutting.speed_mm_s = whole.speed_mm_s();
  cutting.travel_mm_s = whole.travel_mm_s();
  cutting.plunge_mm_s = whole.plunge_mm_s();
  cutting.safe_mm = whole.safe_height_mm();
  cutting.tool_diameter_mm = whole.tool_diameter_mm();
  GiveIf(typed.has_plunge_mm_s(), "PLUNGE", cutting);
  GiveIf(typed.has_safe_height_mm(), "SAFE", cutting);
  return cutting;
}

/// Of all passes of all paths.
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

Result<ContourWork> MakeContourWork(const Course& course, const CourseFiles& files,
                                    const Vec2& start_mm) {
  ContourWork work;
  work.hole_count = files.holes.size();
  PlanHoles(course, files.holes, start_mm, work);
  if (course.make() == COURSE_MAKE_CURVES) {
    if (files.curves.empty()) {
      return Fail(ErrorCode::kMissing,
                  "course.make: curves are those of drawings, and the files have none; "
                  "make an isolation or an outline of a board");
    }
    OrderCurves(course, files.curves, start_mm, work);
    work.element_count = files.curves.size();
    return work;
  }
  std::vector<contour::Element> elements = files.elements;
  auto outlines = INTAGLIO_TRY(OutlinesOf(files.curves));
  std::ranges::move(outlines, std::back_inserter(elements));
  work.element_count = elements.size();
  if (course.make() == COURSE_MAKE_POCKET || course.make() == COURSE_MAKE_CUT) {
    INTAGLIO_TRY(TakeAreas(course, elements, start_mm, work));
    return work;
  }
  const Contours contours =
      INTAGLIO_TRY(ContoursOf(course, elements, files.boards, work));
  OrderContours(course, contours, start_mm, work);
  return work;
}

post::Cutting MillingOf(const Course& whole, const Course& typed) {
  post::Cutting cutting = CommonOf(whole, typed);
  GiveIf(typed.has_speed_mm_s(), "SPEED", cutting);
  GiveIf(typed.has_depth_mm(), "DEPTH", cutting);
  GiveIf(typed.has_power_ratio(), "POWER", cutting);
  if (whole.has_power_ratio()) cutting.power_ratio = whole.power_ratio();
  cutting.depths_mm.clear();
  for (std::uint32_t k = 1; k <= whole.repeat_count(); ++k) {
    cutting.depths_mm.push_back(-whole.depth_mm() * k / whole.repeat_count());
  }
  if (!whole.has_power_ratio())
    cutting.tab_top_mm = std::min(0.0, whole.tab_height_mm() - whole.depth_mm());
  return cutting;
}

post::Cutting DrillingOf(const Course& whole, const Course& typed) {
  post::Cutting cutting = CommonOf(whole, typed);
  GiveIf(typed.has_drill_depth_mm(), "DEPTH", cutting);
  cutting.depths_mm = {-whole.drill_depth_mm()};
  return cutting;
}

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
  std::vector<std::string> lines{fmt::format("elements      {}, {} holes with {} tools",
                                             client::GroupedDigits(work.element_count),
                                             client::GroupedDigits(work.hole_count),
                                             work.rounds.size())};
  if (work.net_count) {
    lines.push_back(fmt::format("isolation     {} nets, {:.3g} mm around the copper",
                                *work.net_count, work.isolated_mm));
  }
  if (work.proved_net_count) {
    lines.push_back(
        fmt::format("copper left   {} nets as the file has them, none short or open",
                    *work.proved_net_count));
  }
  if (whole.make() == COURSE_MAKE_POCKET) {
    lines.push_back(fmt::format(
        "left over     {:.3g} mm2 in corners and necks narrower than the tool",
        work.left_mm2));
  }
  const WorkTime time = TimeOf(work, whole);
  lines.push_back(fmt::format("contours      {}, {:.1f} mm at work, {} times",
                              client::GroupedDigits(work.paths.size()), work.work_mm,
                              whole.repeat_count()));
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
