#include "services/job/course/course_work.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "engrave/contour/contour_order.h"
#include "engrave/contour/isolation.h"
#include "engrave/contour/union.h"
#include "engrave/core/try.h"
#include "services/job/course/course_areas.h"
#include "services/job/course/course_nets.h"
#include "services/job/course/course_tabs.h"

namespace intaglio {
namespace {

/// Diameters within it are those of one tool.
constexpr double kSameDrill_mm = 0.001;

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

/// The sink of the work from `begin` to `end` of `count` parts that take about as long.
ProgressSink PartOf(const ProgressSink& whole, std::uint64_t begin, std::uint64_t end,
                    std::uint64_t count) {
  if (!whole) return {};
  return [=, &whole](std::uint64_t done, std::uint64_t total) {
    return whole(begin * total + (end - begin) * done, count * total);
  };
}

Status KeepCopper(std::span<const contour::Element> elements, contour::Corners corners,
                  ContourWork& work, const ProgressSink& progress) {
  const auto copper = INTAGLIO_TRY(contour::Unite(elements, {0, corners, progress}));
  for (const contour::Contour& contour : copper.contours)
    work.copper.push_back(contour.edges);
  return {};
}

Result<Contours> ContoursOf(const Course& course,
                            std::span<const contour::Element> elements,
                            const std::vector<DrawnNets>& boards, ContourWork& work,
                            const ProgressSink& progress) {
  Contours contours;
  if (elements.empty()) return contours;
  if (course.make() == COURSE_MAKE_ISOLATION) {
    const std::uint64_t unions = 1 + course.pass_count();
    auto made = INTAGLIO_TRY(contour::Isolate(
        elements, {course.tool_diameter_mm(), static_cast<int>(course.pass_count()),
                   course.overlap_ratio(), PartOf(progress, 0, unions, unions + 1)}));
    INTAGLIO_TRY(KeepCopper(elements, contour::Corners::kRound, work,
                            PartOf(progress, unions, unions + 1, unions + 1)));
    work.net_count = made.net_count;
    work.piece_count = made.piece_count;
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
  auto made = INTAGLIO_TRY(contour::Unite(
      rounded, {course.tool_diameter_mm() / 2, corners, PartOf(progress, 0, 1, 2)}));
  INTAGLIO_TRY(KeepCopper(rounded, corners, work, PartOf(progress, 1, 2, 2)));
  contours.Add(std::move(made.contours), 0);
  return contours;
}

Course WithoutTabs(Course course) {
  course.set_tab_count(0);
  course.clear_tab_distance_mm();
  return course;
}

Status OrderContours(const Course& course, const Contours& contours, const Vec2& start_mm,
                     ContourWork& work, const ProgressSink& progress) {
  const Course without_tabs = WithoutTabs(course);
  // The improvement takes some rounds, each about as long as the nearest order.
  auto visits =
      contour::NearestContours(contours.all, start_mm, PartOf(progress, 0, 1, 5));
  work.nearest_idle_mm = contour::IdleWay_mm(contours.all, start_mm, visits);
  if (!course.nearest_order()) {
    contour::ImproveContours(contours.all, start_mm, visits,
                             {.progress = PartOf(progress, 1, 5, 5)});
  }
  if (progress) progress(1, 1);
  work.idle_mm = contour::IdleWay_mm(contours.all, start_mm, visits);
  for (const contour::ContourVisit& visit : visits) {
    const contour::Contour& contour = contours.all[visit.contour];
    work.paths.push_back(INTAGLIO_TRY(PathWithTabs(
        contour.inner ? without_tabs : course, contour::EdgesFrom(contour.edges, visit),
        fmt::format("contour {}", work.paths.size() + 1))));
    work.passes.push_back(contours.passes[visit.contour]);
    work.work_mm += contour.length_mm;
  }
  return {};
}

/// Curves as they are, each from its begin.
Status OrderCurves(const Course& course, const std::vector<DrawnCurve>& curves,
                   const Vec2& start_mm, ContourWork& work,
                   const ProgressSink& progress) {
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
    contour::ImproveOrder(begins, start_mm, improved, {.progress = progress});
    // It measures from begin to begin: of open curves it may be the longer one.
    if (idle_mm(improved) < work.idle_mm) order = std::move(improved);
    work.idle_mm = idle_mm(order);
  }
  const Course without_tabs = WithoutTabs(course);
  for (const std::uint32_t i : order) {
    work.paths.push_back(INTAGLIO_TRY(PathWithTabs(
        curves[i].opening ? without_tabs : course, curves[i].edges, curves[i].name)));
    work.passes.push_back(0);
    work.work_mm += contour::LengthOf(curves[i].edges);
  }
  return {};
}

/// Pockets and cuts: in the order in which they were made.
Status TakeAreas(const Course& course, const std::vector<contour::Element>& elements,
                 const Vec2& start_mm, ContourWork& work, const ProgressSink& progress) {
  const AreaPaths made = INTAGLIO_TRY(course.make() == COURSE_MAKE_POCKET
                                          ? ClearAreas(course, elements, start_mm)
                                          : CutAreas(course, elements));
  INTAGLIO_TRY(KeepCopper(elements, contour::Corners::kRound, work, progress));
  work.left_mm2 = made.left_mm2;
  work.left_at_wall_mm = made.left_at_wall_mm;
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
               const Vec2& start_mm, ContourWork& work, const ProgressSink& progress) {
  const auto tools =
      contour::PlanDrilling(holes, start_mm,
                            course.nearest_order() ? contour::OrderKind::kNearest
                                                   : contour::OrderKind::kImproved,
                            {.progress = progress});
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

/// Holes that are made (course.drill_diameter_mm).
Result<std::vector<contour::Hole>> HolesOf(const Course& course,
                                           const std::vector<contour::Hole>& holes) {
  if (!course.has_drill_diameter_mm()) return holes;
  std::vector<contour::Hole> made;
  std::set<double> others_mm;
  for (const contour::Hole& hole : holes) {
    if (std::abs(hole.diameter_mm - course.drill_diameter_mm()) < kSameDrill_mm)
      made.push_back(hole);
    else
      others_mm.insert(hole.diameter_mm);
  }
  if (course.drill_diameter_mm() == 0 || !made.empty()) return made;
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("course.drill_diameter_mm: no hole has {:g} mm; the files have "
                          "holes of {:g} mm: give one of these, or 0 for the contours",
                          course.drill_diameter_mm(), fmt::join(others_mm, ", ")),
              fmt::format("{:g}", course.drill_diameter_mm()));
}

Result<ContourWork> MakeWork(const Course& course, const CourseFiles& files,
                             const Vec2& start_mm, const CourseProgress& progress) {
  ContourWork work;
  const auto holes = INTAGLIO_TRY(HolesOf(course, files.holes));
  work.hole_count = holes.size();
  PlanHoles(course, holes, start_mm, work, progress.order);
  if (course.drill_diameter_mm() > 0) return work;
  if (course.make() == COURSE_MAKE_CURVES) {
    if (files.curves.empty()) {
      return Fail(ErrorCode::kMissing,
                  "course.make: curves are those of drawings, and the files have none; "
                  "make an isolation or an outline of a board");
    }
    INTAGLIO_TRY(OrderCurves(course, files.curves, start_mm, work, progress.order));
    work.element_count = files.curves.size();
    return work;
  }
  const std::vector<contour::Element>& elements = files.elements;
  work.element_count = elements.size();
  if (course.make() == COURSE_MAKE_POCKET || course.make() == COURSE_MAKE_CUT) {
    INTAGLIO_TRY(TakeAreas(course, elements, start_mm, work, progress.contours));
    return work;
  }
  const Contours contours =
      INTAGLIO_TRY(ContoursOf(course, elements, files.boards, work, progress.contours));
  INTAGLIO_TRY(OrderContours(course, contours, start_mm, work, progress.order));
  return work;
}

}  // namespace

Result<ContourWork> MakeContourWork(const Course& course, const CourseFiles& files,
                                    const Vec2& start_mm,
                                    const CourseProgress& progress) {
  // An order that is cancelled is the one that was found so far.
  bool cancelled = false;
  CourseProgress observed = progress;
  if (progress.order) {
    observed.order = [&](std::uint64_t done, std::uint64_t total) {
      cancelled = cancelled || !progress.order(done, total);
      return !cancelled;
    };
  }
  auto work = MakeWork(course, files, start_mm, observed);
  if (work && cancelled)
    return Fail(ErrorCode::kCancelled, "the order of the contours was cancelled");
  return work;
}

post::Cutting PassesOf(const Course& course) {
  post::Cutting cutting;
  cutting.depths_mm.clear();
  for (std::uint32_t k = 1; k <= course.repeat_count(); ++k)
    cutting.depths_mm.push_back(-course.depth_mm() * k / course.repeat_count());
  if (course.has_power_ratio())
    cutting.power_ratio = course.power_ratio();
  else
    cutting.tab_top_mm = std::min(0.0, course.tab_height_mm() - course.depth_mm());
  return cutting;
}

}  // namespace intaglio
