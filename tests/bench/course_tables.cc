// Speed through corners: every law on one program, one corner of 90 degrees, and the time
// of planning. Tables for docs/measurements.md.
//   course_tables [program|corner|time|margin|content|long]
//   course_tables svg FILE SEED: the program of this seed as a drawing, in mm

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <memory>
#include <numbers>
#include <string>

#include "engrave/course/margin.h"
#include "engrave/course/plan.h"
#include "engrave/course/source_law.h"
#include "engrave/course/swing_table.h"
#include "tests/bench/junction_laws.h"
#include "tests/engrave/course/cut_program.h"

namespace intaglio::course {
namespace {

constexpr double kFeedMmS = 100, kToleranceMm = 0.1, kAcceleration = 2000;
constexpr std::uint64_t kSeed = 2026;

using Program = std::vector<Path>;
using NodeSpeeds = std::function<std::vector<double>(const Path&)>;

const AxisPair kMachine = MeasuredMachine();

struct Cut {
  double duration_s = 0, one_sided_mm = 0, node_miss_mm = 0, motor_mm_s2 = 0;
  double setpoints_s = 0;  ///< with what the kernel or the lag adds to each contour
  bool holds = true;

  void Add(const CoursePlan& plan) {
    duration_s += plan.law.duration_s;
    setpoints_s +=
        plan.law.duration_s + plan.tracking.kernel_s.value_or(0) + plan.tracking.smooth_s;
    one_sided_mm = std::max(one_sided_mm, plan.worst_one_sided_mm);
    node_miss_mm = std::max(node_miss_mm, plan.worst_node_miss_mm);
    motor_mm_s2 = std::max(motor_mm_s2, plan.motor_mm_s2);
    holds = holds && plan.holds;
  }
  double worst_mm() const { return std::max(one_sided_mm, node_miss_mm); }
};

Cut CutBy(const Program& program, const NodeSpeeds& law, double acceleration_mm_s2) {
  Cut cut;
  PlanOptions options;
  options.acceleration_mm_s2 = acceleration_mm_s2;
  for (const Path& path : program) {
    cut.Add(EvaluateLaw(path, kMachine, PlanSpeeds(path, law(path), acceleration_mm_s2),
                        options));
  }
  return cut;
}

Cut CutByPlan(const Program& program, PlanOptions options) {
  Cut cut;
  options.swings = std::make_shared<SwingTable>();
  for (const Path& path : program) cut.Add(PlanCourse(path, kMachine, options).value());
  return cut;
}

void Print(const std::string& name, const Cut& cut, double stopping_s) {
  fmt::print("| {} | {:.1f} | {:.1f} % | {:.1f} / {:.1f} | {:.1f} |{}\n", name,
             cut.duration_s, 100 * (1 - cut.duration_s / stopping_s),
             1e3 * cut.one_sided_mm, 1e3 * cut.node_miss_mm, cut.motor_mm_s2 / 1e3,
             cut.holds ? "" : " over");
  std::fflush(stdout);
}

/// The largest parameter of a falling series whose law holds the tolerance.
std::pair<double, Cut> LargestThatHolds(const Program& program, double from,
                                        double factor, double acceleration_mm_s2,
                                        const std::function<NodeSpeeds(double)>& law_of) {
  double parameter = from;
  for (int i = 0; i < 60; ++i, parameter *= factor) {
    const Cut cut = CutBy(program, law_of(parameter), acceleration_mm_s2);
    if (cut.worst_mm() <= kToleranceMm * 1.0001) return {parameter, cut};
  }
  return {parameter, {}};
}

void PrintJunctionLaws(const Program& program, double stopping_s) {
  const auto grbl = [](double deviation_mm) -> NodeSpeeds {
    return [deviation_mm](const Path& path) {
      return GrblNodeSpeeds(path, deviation_mm, kAcceleration);
    };
  };
  const auto klipper = [](double speed_mm_s) -> NodeSpeeds {
    return [speed_mm_s](const Path& path) {
      return KlipperNodeSpeeds(path, speed_mm_s, kAcceleration);
    };
  };
  const auto [deviation, by_grbl] =
      LargestThatHolds(program, 0.01, 0.9, kAcceleration, grbl);
  Print(fmt::format("grblHAL, junction deviation {:.2f} um", 1e3 * deviation), by_grbl,
        stopping_s);
  const auto [speed, by_klipper] =
      LargestThatHolds(program, 10, 0.95, kAcceleration, klipper);
  Print(fmt::format("Klipper, square corner velocity {:.2f} mm/s", speed), by_klipper,
        stopping_s);
}

void PrintSourceLaws(const Program& program, double stopping_s) {
  const auto source = [](double allowance) -> NodeSpeeds {
    return [allowance](const Path& path) {
      return SourceNodeSpeeds(path, kMachine, {kToleranceMm, allowance, true});
    };
  };
  Print("source, as published", CutBy(program, source(1), kAcceleration), stopping_s);
  for (const double a : {1000.0, 1250.0, 1500.0, 1750.0, kAcceleration}) {
    Print(fmt::format("source, .45 of the tolerance, a {:.1f}", a / 1e3),
          CutBy(program, source(kSourceAllowanceRatio), a), stopping_s);
    const auto [allowance, cut] = LargestThatHolds(program, 0.6, 0.985, a, source);
    Print(fmt::format("source, {:.2f} of the tolerance, a {:.1f}: the most that holds",
                      allowance, a / 1e3),
          cut, stopping_s);
  }
}

void PrintProgram(const Program& program) {
  const double stopping_s = StoppingDurationS(program, kAcceleration);
  const auto nodes_at = [](double v) -> NodeSpeeds {
    return
        [v](const Path& path) { return std::vector<double>(path.node_count() - 2, v); };
  };
  fmt::print("{:.1f} m, {} contours, {} segments\n\n", LengthMm(program) / 1e3,
             program.size(), SegmentCount(program));
  fmt::print(
      "| law | time s | saved | one-sided / node miss um | motor m/s2 |\n"
      "|---|---|---|---|---|\n");
  Print("stop at every node", CutBy(program, nodes_at(0), kAcceleration), stopping_s);
  PrintJunctionLaws(program, stopping_s);
  PrintSourceLaws(program, stopping_s);
  Print("whole contour predicted, a 2", CutByPlan(program, {}), stopping_s);
  for (const double motor : {6000.0, 11000.0}) {
    const Cut cut = CutByPlan(program, CompensatedOptions(motor));
    Print(fmt::format("compensated, motor <= {:.0f}", motor / 1e3), cut, stopping_s);
    fmt::print("| with the kernel's own time | {:.1f} | {:.1f} % | | |\n",
               cut.setpoints_s, 100 * (1 - cut.setpoints_s / stopping_s));
  }
  Print("feed through every node", CutBy(program, nodes_at(kFeedMmS), kAcceleration),
        stopping_s);
}

double TimeAt(const SpeedLaw& law, double s_mm) {
  double from_s = 0, to_s = law.duration_s;
  for (int i = 0; i < 60; ++i) {
    const double middle_s = (from_s + to_s) / 2;
    (SampleLaw(law, 1, middle_s, 1).front() < s_mm ? from_s : to_s) = middle_s;
  }
  return from_s;
}

/// The time that the corner in the middle costs: between the middles of both legs, where
/// the speed is the feed.
double LostS(const CoursePlan& plan, double leg_mm) {
  return TimeAt(plan.law, 1.5 * leg_mm) - TimeAt(plan.law, 0.5 * leg_mm) -
         leg_mm / kFeedMmS;
}

struct BestCorner {
  double lost_s = 1e9;
  CoursePlan plan;
};

/// A corner of 90 degrees, the worse of both orders of the axes.
BestCorner WorseOrder(const PlanOptions& options) {
  constexpr double kLegMm = 30;
  BestCorner worse{-1, {}};
  for (const double first : {0.0, std::numbers::pi / 2}) {
    const Path path = CornerPath(first, std::numbers::pi / 2, kLegMm, kFeedMmS);
    const CoursePlan plan = PlanCourse(path, kMachine, options).value();
    const double lost_s = plan.holds ? LostS(plan, kLegMm) : 1e9;
    if (lost_s >= worse.lost_s) worse = {lost_s, plan};
  }
  return worse;
}

/// Over the length of the kernel and the acceleration.
BestCorner BestOf(double motor_mm_s2) {
  BestCorner best;
  for (double kernel_s = 0.012; kernel_s <= 0.06; kernel_s += 0.002) {
    for (const double share : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8}) {
      PlanOptions options = CompensatedOptions(motor_mm_s2);
      options.kernel_s = kernel_s;
      options.acceleration_mm_s2 = share * motor_mm_s2;
      options.period_s = 0.00025;
      if (BestCorner corner = WorseOrder(options); corner.lost_s < best.lost_s)
        best = std::move(corner);
    }
  }
  return best;
}

void PrintCorner() {
  // Lower bounds by linear programming for any command, ms: docs/measurements.md.
  const std::pair<double, double> bounds[] = {
      {2000, 24}, {3000, 10}, {6000, 2}, {11000, 2}};
  fmt::print(
      "\n| motor m/s2 | lost ms | bound ms | kernel ms | a m/s2 | corner mm/s |\n"
      "|---|---|---|---|---|---|\n");
  for (const auto& [motor, bound_ms] : bounds) {
    const BestCorner best = BestOf(motor);
    fmt::print("| {:.0f} | {:.1f} | {:.0f} | {:.0f} | {:.1f} | {:.0f} |\n", motor / 1e3,
               1e3 * best.lost_s, bound_ms, 1e3 * best.plan.tracking.kernel_s.value_or(0),
               best.plan.acceleration_mm_s2 / 1e3, best.plan.nodes.at(1).speed_mm_s);
  }
}

void PrintPlanningTime() {
  Program program = CutProgram(47, kFeedMmS, kSeed + 1);
  while (SegmentCount(program) > 10100) program.pop_back();
  fmt::print("\n| planning {} segments, {:.1f} m | s |\n|---|---|\n",
             SegmentCount(program), LengthMm(program) / 1e3);
  const auto measure = [&](const std::string& name, const PlanOptions& options) {
    // The processor's time, so that a busy machine does not count.
    const std::clock_t begin = std::clock();
    const Cut cut = CutByPlan(program, options);
    const double took_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    fmt::print("| {}, worst {:.1f} um | {:.2f} |\n", name, 1e3 * cut.worst_mm(), took_s);
  };
  measure("whole contour predicted, setpoints 0.5 ms", {});
  for (const double period_s : {0.0005, 0.001}) {
    PlanOptions options = CompensatedOptions(11000);
    options.period_s = period_s;
    measure(fmt::format("compensated, setpoints {:.1f} ms", 1e3 * period_s), options);
  }
}

/// What each kind of contour gains by its plan: a program of this kind alone.
void PrintContent() {
  const std::pair<const char*, ProgramMix> kinds[] = {{"rectangles", {1, 0, 0, 0}},
                                                      {"gears", {0, 1, 0, 0}},
                                                      {"curves", {0, 0, 1, 0}},
                                                      {"zigzag", {0, 0, 0, 1}}};
  fmt::print(
      "\n| content | stops s | predicted | compensated, motor 6 | motor 11 |\n"
      "|---|---|---|---|---|\n");
  for (const auto& [name, mix] : kinds) {
    const Program program = CutProgram(8, kFeedMmS, kSeed + 3, mix);
    const double stopping_s = StoppingDurationS(program, kAcceleration);
    fmt::print("| {} | {:.1f} |", name, stopping_s);
    for (const PlanOptions& options :
         {PlanOptions{}, CompensatedOptions(6000), CompensatedOptions(11000)}) {
      const Cut cut = CutByPlan(program, options);
      fmt::print(" {:.1f} %{} |", 100 * (1 - cut.duration_s / stopping_s),
                 cut.holds ? "" : " over");
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

/// One contour of 100 000 segments, planned and tried on machines that differ.
void PrintLongContour() {
  const Path path = JoinedPath(CutProgram(480, kFeedMmS, kSeed + 4));
  for (const bool reserve : {false, true}) {
    const std::clock_t begin = std::clock();
    PlanWithMargin found;
    if (reserve) {
      found = PlanWithin(path, kMachine, CompensatedOptions(), {}).value();
    } else {
      found.plan = PlanCourse(path, kMachine, CompensatedOptions()).value();
      found.margin = CheckMargin(path, found.plan, kMachine, kToleranceMm, {});
    }
    fmt::print("| one contour, {} segments, {:.1f} m{}, {} | {:.1f} |\n",
               path.segment_count(), path.length_mm() / 1e3,
               reserve ? ", with a reserve" : "", found.plan.holds ? "holds" : "over",
               static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
}

void PrintMargins() {
  const Program program = CutProgram(8, kFeedMmS, kSeed + 2);
  const double stopping_s = StoppingDurationS(program, kAcceleration);
  fmt::print(
      "\n| mechanics wrong by 5 % or 20 % | time s | saved | worst um | contours "
      "over |\n|---|---|---|---|---|\n");
  for (const bool reserve : {false, true}) {
    double duration_s = 0, worst_mm = 0;
    int over = 0;
    PlanOptions options = CompensatedOptions(11000);
    options.swings = std::make_shared<SwingTable>();
    for (const Path& path : program) {
      PlanWithMargin found;
      if (reserve) {
        found = PlanWithin(path, kMachine, options, {}).value();
      } else {
        found.plan = PlanCourse(path, kMachine, options).value();
        found.margin = CheckMargin(path, found.plan, kMachine, kToleranceMm, {});
      }
      duration_s += found.plan.law.duration_s;
      worst_mm = std::max(worst_mm, found.margin.worst.worst_mm);
      over += found.margin.holds ? 0 : 1;
    }
    fmt::print("| {} | {:.1f} | {:.1f} % | {:.1f} | {} of {} |\n",
               reserve ? "planned with a reserve" : "planned for the model", duration_s,
               100 * (1 - duration_s / stopping_s), 1e3 * worst_mm, over, program.size());
  }
}

/// The places of the contours are those of the program, moved to positive coordinates.
int WriteDrawing(const Program& program, const std::string& file) {
  Eigen::AlignedBox2d box;
  for (const Path& path : program) {
    for (std::size_t k = 0; k < path.node_count(); ++k) box.extend(path.node_mm(k));
  }
  std::ofstream out(file);
  const Vec2 size_mm = box.sizes();
  out << fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0:.4f}mm' height='{1:.4f}mm' "
      "viewBox='0 0 {0:.4f} {1:.4f}' fill='none' stroke='black'>\n",
      size_mm.x(), size_mm.y());
  for (const Path& path : program) {
    out << "<polyline points='";
    for (std::size_t k = 0; k < path.node_count(); ++k) {
      const Vec2 place_mm = path.node_mm(k) - box.min();
      out << fmt::format("{:.4f},{:.4f} ", place_mm.x(), size_mm.y() - place_mm.y());
    }
    out << "'/>\n";
  }
  out << "</svg>\n";
  return out.good() ? 0 : 1;
}

}  // namespace
}  // namespace intaglio::course

int main(int argc, char** argv) {
  using namespace intaglio::course;
  const std::string which = argc > 1 ? argv[1] : "all";
  if (which == "svg" && argc == 4)
    return WriteDrawing(CutProgram(32, kFeedMmS, std::stoull(argv[3])), argv[2]);
  const auto wanted = [&](const char* name) { return which == name || which == "all"; };
  if (wanted("program")) PrintProgram(CutProgram(32, kFeedMmS, kSeed));
  if (wanted("corner")) PrintCorner();
  if (wanted("time")) PrintPlanningTime();
  if (wanted("margin")) PrintMargins();
  if (wanted("content")) PrintContent();
  if (wanted("long")) PrintLongContour();
  return 0;
}
