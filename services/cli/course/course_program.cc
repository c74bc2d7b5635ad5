#include "services/cli/course/course_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/course/swing_table.h"
#include "engrave/io/atomic_file.h"
#include "services/client/figure_text.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {
namespace {

/// A picture does not show more samples than it has pixels.
constexpr std::size_t kMaxDrawnSamples = 200'000;

/// The course of the model's axes, with the nearest place of each of its points.
struct FollowedCourse {
  course::Tracked tracked;
  std::vector<course::NearestPlace> places;
  std::vector<double> speed_mm_s;
};

FollowedCourse CourseOf(const CourseProgram& program, const PlannedContour& contour) {
  FollowedCourse found;
  found.tracked =
      course::FollowPlan(contour.path, contour.plan, program.axes, program.axes);
  const course::Tracked& tracked = found.tracked;
  found.places.resize(tracked.actual_mm.size());
  course::MeasureContour(
      contour.path, tracked.actual_mm, tracked.commanded_s_mm,
      course::Tracking(program.axes, contour.plan.tracking)
          .WindowFor(contour.path.greatest_feed_mm_s(), program.options.tolerance_mm),
      found.places);
  found.speed_mm_s = course::SampleSpeed(contour.plan.law, tracked.period_s,
                                         tracked.first_s, tracked.actual_mm.size());
  return found;
}

double Worst(const CourseProgram& program, double (*of)(const PlannedContour&)) {
  double worst = 0;
  for (const PlannedContour& contour : program.contours)
    worst = std::max(worst, of(contour));
  return worst;
}

std::string LawText(const CourseProgram& program) {
  if (!program.options.compensate) {
    return fmt::format("node speeds by the predicted contour, setpoints every {:g} ms",
                       1e3 * program.options.period_s);
  }
  const double kernel_s = Worst(program, [](const PlannedContour& c) {
    return c.plan.tracking.kernel_s.value_or(0);
  });
  return fmt::format(
      "compensated by the inverse of the axes, kernels up to {:.1f} ms, setpoints every "
      "{:g} ms",
      1e3 * kernel_s, 1e3 * program.options.period_s);
}

std::string MarginText(const CourseProgram& program) {
  const double worst_mm =
      Worst(program, [](const PlannedContour& c) { return c.margin.worst.worst_mm; });
  const auto over = std::ranges::count_if(
      program.contours, [](const PlannedContour& c) { return !c.margin.holds; });
  const std::string wrong =
      fmt::format("mechanics wrong by {:g} % in frequency or {:g} % in damping",
                  100 * program.error.frequency, 100 * program.error.damping);
  if (over == 0) {
    return fmt::format("holds with {}: {:.1f} um", wrong, 1e3 * worst_mm);
  }
  return fmt::format(
      "does not hold with {}: {:.1f} um, {} over; plan with "
      "--reserve, or identify the axes more exactly",
      wrong, 1e3 * worst_mm, Counted(static_cast<std::uint64_t>(over), "contour"));
}

const PlannedContour* FirstNotHeld(const CourseProgram& program) {
  const auto found = std::ranges::find_if(
      program.contours, [](const PlannedContour& c) { return !c.plan.holds; });
  return found == program.contours.end() ? nullptr : &*found;
}

/// Segments of a contour from which on its own parts are work for all cores.
constexpr std::size_t kLongContour = 2000;

Status PlanContour(const course::AxisPair& axes, const course::PlanOptions& options,
                   const course::ModelError& error, bool reserve,
                   PlannedContour& contour) {
  if (reserve) {
    auto found = INTAGLIO_TRY(course::PlanWithin(contour.path, axes, options, error));
    contour.plan = std::move(found.plan);
    contour.margin = std::move(found.margin);
    contour.planned_ratio = found.planned_ratio;
    return {};
  }
  contour.plan = INTAGLIO_TRY(course::PlanCourse(contour.path, axes, options));
  contour.margin = course::CheckMargin(contour.path, contour.plan, axes,
                                       options.tolerance_mm, error, options.executor);
  return {};
}

}  // namespace

bool CourseProgram::holds() const {
  return std::ranges::all_of(contours,
                             [](const PlannedContour& c) { return c.plan.holds; });
}

double CourseProgram::duration_s() const {
  double sum_s = 0;
  for (const PlannedContour& contour : contours) sum_s += contour.plan.law.duration_s;
  return sum_s;
}

double CourseProgram::length_mm() const {
  double sum_mm = 0;
  for (const PlannedContour& contour : contours) sum_mm += contour.path.length_mm();
  return sum_mm;
}

Result<CourseProgram> PlanProgram(std::vector<course::Path> paths,
                                  const course::AxisPair& axes,
                                  const course::PlanOptions& options,
                                  const course::ModelError& error, bool reserve) {
  CourseProgram program{axes, options, error, {}, 0};
  program.options.swings = std::make_shared<course::SwingTable>();
  for (course::Path& path : paths) {
    const std::vector<double> stops(path.node_count() - 2, 0);
    program.stopping_s +=
        course::PlanSpeeds(path, stops, options.acceleration_mm_s2).duration_s;
    program.contours.push_back({std::move(path), {}, {}, options.planned_ratio});
  }
  // Long contours one by one, their parts on all cores; then the others side by side.
  const Executor cores = host::AllCores();
  std::vector<PlannedContour*> others;
  for (PlannedContour& contour : program.contours) {
    if (contour.path.segment_count() < kLongContour) {
      others.push_back(&contour);
      continue;
    }
    course::PlanOptions on_all = program.options;
    on_all.executor = cores;
    INTAGLIO_TRY(PlanContour(axes, on_all, error, reserve, contour));
  }
  std::vector<Status> planned(others.size());
  RunEach(cores, others.size(), [&](std::size_t i) {
    planned[i] = PlanContour(axes, program.options, error, reserve, *others[i]);
  });
  for (Status& status : planned) INTAGLIO_TRY(std::move(status));
  return program;
}

CoursePlan ReportOf(const CourseProgram& program) {
  CoursePlan report;
  report.set_contour_count(program.contours.size());
  std::size_t segments = 0;
  bool margin_holds = true;
  for (const PlannedContour& contour : program.contours) {
    segments += contour.path.segment_count();
    margin_holds = margin_holds && contour.margin.holds;
  }
  const auto worst_um = [&](double (*of)(const PlannedContour&)) {
    return 1e3 * Worst(program, of);
  };
  report.set_segment_count(segments);
  report.set_length_mm(program.length_mm());
  report.set_duration_s(program.duration_s());
  report.set_stopping_s(program.stopping_s);
  report.set_tolerance_um(1e3 * program.options.tolerance_mm);
  report.set_max_course_error_um(
      worst_um([](const PlannedContour& c) { return c.plan.worst_one_sided_mm; }));
  report.set_max_node_error_um(
      worst_um([](const PlannedContour& c) { return c.plan.worst_node_miss_mm; }));
  report.set_holds(program.holds());
  report.set_wrong_mechanics_max_um(
      worst_um([](const PlannedContour& c) { return c.margin.worst.worst_mm; }));
  report.set_margin_holds(margin_holds);
  report.set_compensated(program.options.compensate);
  return report;
}

std::vector<std::string> FiguresOf(const CourseProgram& program) {
  std::size_t segments = 0;
  for (const PlannedContour& contour : program.contours)
    segments += contour.path.segment_count();
  const auto worst_um = [&](double (*of)(const PlannedContour&)) {
    return 1e3 * Worst(program, of);
  };
  std::vector<std::string> lines{
      fmt::format("contours      {}, {}, {:.1f} mm", program.contours.size(),
                  client::GroupedCount(segments, "segment"), program.length_mm()),
      fmt::format("law           {}", LawText(program)),
      fmt::format("time          {}, {:.1f} % less than with a stop at every node ({})",
                  client::ShortDuration(program.duration_s()),
                  100 * (1 - program.duration_s() / program.stopping_s),
                  client::ShortDuration(program.stopping_s)),
      fmt::format(
          "deviation     {:.1f} um from the path, {:.1f} um from its nodes; "
          "allowed {:.1f} um",
          worst_um([](const PlannedContour& c) { return c.plan.worst_one_sided_mm; }),
          worst_um([](const PlannedContour& c) { return c.plan.worst_node_miss_mm; }),
          1e3 * program.options.tolerance_mm),
      fmt::format(
          "motors        {:.0f} mm/s^2",
          Worst(program, [](const PlannedContour& c) { return c.plan.motor_mm_s2; })),
      fmt::format("margin        {}", MarginText(program))};
  if (const PlannedContour* failed = FirstNotHeld(program))
    lines.push_back("not held      " + failed->plan.reason);
  return lines;
}

Status WriteCourseTable(const std::string& file, const CourseProgram& program) {
  auto table = INTAGLIO_TRY(io::AtomicFile::Create(file));
  INTAGLIO_TRY(table.Write(
      "contour,time_s,setpoint_x_mm,setpoint_y_mm,actual_x_mm,actual_y_mm,s_mm,"
      "speed_mm_s,deviation_um\n"));
  for (std::size_t k = 0; k < program.contours.size(); ++k) {
    const FollowedCourse course = CourseOf(program, program.contours[k]);
    const course::Tracked& tracked = course.tracked;
    for (std::size_t i = 0; i < tracked.actual_mm.size(); ++i) {
      INTAGLIO_TRY(table.Write(fmt::format(
          "{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.4f},{:.3f}\n", k + 1,
          tracked.first_s + tracked.period_s * static_cast<double>(i),
          tracked.setpoints_mm[i].x(), tracked.setpoints_mm[i].y(),
          tracked.actual_mm[i].x(), tracked.actual_mm[i].y(), course.places[i].s_mm,
          course.speed_mm_s[i], 1e3 * course.places[i].distance_mm)));
    }
  }
  return table.Commit();
}

render::CoursePicture PictureOf(const CourseProgram& program, const std::string& title) {
  render::CoursePicture picture;
  picture.title = title;
  picture.tolerance_mm = program.options.tolerance_mm;
  picture.figures = FiguresOf(program);
  const auto samples =
      static_cast<std::size_t>(program.duration_s() / program.options.period_s);
  const std::size_t step = samples / kMaxDrawnSamples + 1;
  double begin_mm = 0;
  for (const PlannedContour& contour : program.contours) {
    std::vector<Vec2> nodes_mm;
    for (std::size_t k = 0; k < contour.path.node_count(); ++k)
      nodes_mm.push_back(contour.path.node_mm(k));
    picture.paths_mm.push_back(std::move(nodes_mm));
    const FollowedCourse course = CourseOf(program, contour);
    course::PathCursor cursor(contour.path);
    std::vector<render::CourseSample> drawn;
    for (std::size_t i = 0; i < course.places.size(); i += step) {
      const Vec2 place_mm = cursor.PointAt(course.places[i].s_mm);
      drawn.push_back({place_mm, course.tracked.actual_mm[i] - place_mm,
                       begin_mm + course.places[i].s_mm, course.speed_mm_s[i]});
    }
    picture.courses.push_back(std::move(drawn));
    begin_mm += contour.path.length_mm();
  }
  return picture;
}

}  // namespace intaglio::cli
