// `intaglio drive simulate`: a move or a step of one axis as its controller drives it;
// course_simulation.cc has circles and corners of two.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/drive/continuous_axis.h"
#include "engrave/drive/two_axes.h"
#include "engrave/io/atomic_file.h"
#include "engrave/render/chart.h"
#include "engrave/render/png_file.h"
#include "proto/drive_report.pb.h"
#include "services/cli/drive/drive_command.h"
#include "services/cli/drive/simulate_options.h"
#include "services/cli/flags/drive_profile_flag.h"
#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/job/drive/drive_profile.h"

namespace intaglio::cli {
namespace {

Result<DriveAxis> AxisNamed(const DriveProfile& profile, const std::string& name) {
  std::string known;
  for (const DriveAxis& axis : profile.axes()) {
    if (name.empty() || axis.name() == name) return axis;
    known += (known.empty() ? "" : ", ") + axis.name();
  }
  return Fail(
      ErrorCode::kNotFound,
      fmt::format("--axis {}: the profile has no such axis; it has {}", name, known),
      name);
}

Result<std::vector<double>> SetpointsOf(const DriveSimulateOptions& options,
                                        double period_s) {
  const double length_m = options.length_mm / 1000;
  std::vector<drive::CommandPiece> pieces = {{{length_m, 0, 0, 0}, options.rest_s}};
  if (!options.step) {
    pieces = drive::Trapezoid(length_m, options.speed_mm_s / 1000,
                              options.acceleration_mm_s2 / 1000, options.rest_s);
  }
  double total_s = 0;
  for (const drive::CommandPiece& piece : pieces) total_s += piece.duration_s;
  INTAGLIO_TRY(CheckSampleCount(total_s, period_s));
  return drive::SampleCommand(pieces, period_s);
}

Status WriteTable(const std::string& file, double period_s,
                  const std::vector<double>& setpoints,
                  const std::vector<drive::AxisSample>& samples) {
  std::string text =
      "time_s,setpoint_m,position_m,speed_m_s,acceleration_m_s2,volt,following_error_m\n";
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const drive::AxisSample& s = samples[i];
    text += fmt::format("{},{},{},{},{},{},{}\n", static_cast<double>(i) * period_s,
                        setpoints[i], s.position_m, s.speed_m_s, s.acceleration_m_s2,
                        s.volt, s.following_error_m);
  }
  return io::WriteFileAtomically(file, std::string_view(text));
}

Status WritePicture(const DriveSimulateOptions& options, double period_s,
                    const std::vector<double>& setpoints,
                    const std::vector<drive::AxisSample>& samples) {
  render::Curve commanded{options.step ? "setpoint" : "commanded speed", {}};
  render::Curve actual{options.step ? "position" : "speed", {}};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t_ms = 1e3 * static_cast<double>(i) * period_s;
    const double before = i == 0 ? setpoints[0] : setpoints[i - 1];
    commanded.points.emplace_back(
        t_ms, 1e3 * (options.step ? setpoints[i] : (setpoints[i] - before) / period_s));
    actual.points.emplace_back(
        t_ms, 1e3 * (options.step ? samples[i].position_m : samples[i].speed_m_s));
  }
  const render::ChartOptions chart{
      fmt::format("{} of axis {}", options.step ? "Step" : "Move", options.axis),
      "time, ms", options.step ? "position, mm" : "speed, mm/s"};
  return render::WritePng(options.picture, render::DrawChart({commanded, actual}, chart));
}

void PrintFigures(const DriveSimulation& figures) {
  std::cout << fmt::format(
      "axis          {}, {}\n"
      "error         {:.5g} um largest, {:.5g} um at the end\n"
      "overshoot     {:.5g} um\n"
      "acceleration  {:.5g}..{:.5g} m/s^2\n"
      "output        {:.4g} V largest\n",
      figures.axis(), client::GroupedCount(figures.sample_count(), "sample"),
      figures.max_error_um(), figures.end_error_um(), figures.overshoot_um(),
      figures.min_acceleration_m_s2(), figures.max_acceleration_m_s2(),
      figures.max_output_v());
}

Result<DriveSimulation> SimulateAndWrite(DriveSimulateOptions options,
                                         const DriveProfile& profile) {
  const auto of_profile = INTAGLIO_TRY(AxisNamed(profile, options.axis));
  options.axis = of_profile.name();
  const drive::SampledAxis axis = SimulatedAxis(options, profile, of_profile);
  const auto setpoints = INTAGLIO_TRY(SetpointsOf(options, axis.period_s));
  const auto samples = INTAGLIO_TRY(drive::Simulate(axis, setpoints));
  if (!options.csv.empty())
    INTAGLIO_TRY(WriteTable(options.csv, axis.period_s, setpoints, samples));
  if (!options.picture.empty())
    INTAGLIO_TRY(WritePicture(options, axis.period_s, setpoints, samples));
  return FiguresOfAxis(options.axis, setpoints, samples);
}

int SimulateAxis(const DriveSimulateOptions& options) {
  const auto profile = NamedDriveProfile(options.profile);
  if (!profile) return Complain(profile.error(), client::kExitWrongInput);
  if (options.is_course()) {
    const auto course = SimulateCourse(options, *profile);
    if (!course) return Complain(course.error(), client::kExitWrongInput);
    if (options.json) return PrintJson(*course);
    PrintCourse(*course);
    return client::kExitGood;
  }
  const auto figures = SimulateAndWrite(options, *profile);
  if (!figures) return Complain(figures.error(), client::kExitWrongInput);
  if (options.json) return PrintJson(*figures);
  PrintFigures(*figures);
  return client::kExitGood;
}

}  // namespace

drive::SampledAxis SimulatedAxis(const DriveSimulateOptions& options,
                                 const DriveProfile& profile, const DriveAxis& of) {
  drive::SampledAxis axis = SampledAxisOf(profile, of, kSimulatedRule);
  axis.load_m_s2 =
      drive::LoadAcceleration(MotorOf(of), VelocityLoopOf(of, kSimulatedRule),
                              of.screw().lead_m(), options.load_nm);
  if (options.ideal) {
    axis.volt_per_step = axis.max_volt = axis.counts_per_m = std::nullopt;
    axis.friction_m_s2 = 0;
  }
  return axis;
}

Status CheckSampleCount(double total_s, double period_s) {
  if (total_s / period_s <= kMaxSimulatedSamples) return {};
  return Fail(ErrorCode::kTooLarge,
              fmt::format("{:.4g} s are {:.4g} periods of the controller; simulate a "
                          "shorter move",
                          total_s, total_s / period_s));
}

DriveSimulation FiguresOfAxis(const std::string& name, std::span<const double> setpoints,
                              std::span<const drive::AxisSample> samples) {
  double error_m = 0, volt = 0, farthest_m = 0, a_min = 0, a_max = 0;
  for (const drive::AxisSample& s : samples) {
    error_m = std::max(error_m, std::abs(s.following_error_m));
    volt = std::max(volt, std::abs(s.volt));
    farthest_m = std::max(farthest_m, s.position_m);
    a_min = std::min(a_min, s.acceleration_m_s2);
    a_max = std::max(a_max, s.acceleration_m_s2);
  }
  DriveSimulation figures;
  figures.set_axis(name);
  figures.set_sample_count(samples.size());
  figures.set_max_error_um(1e6 * error_m);
  figures.set_end_error_um(1e6 * samples.back().following_error_m);
  figures.set_overshoot_um(1e6 * std::max(0.0, farthest_m - setpoints.back()));
  figures.set_min_acceleration_m_s2(a_min);
  figures.set_max_acceleration_m_s2(a_max);
  figures.set_max_output_v(volt);
  return figures;
}

void AddDriveSimulateCommand(command_line::Command drive) {
  auto o = std::make_shared<DriveSimulateOptions>();
  command_line::Command simulate =
      drive.AddCommand("simulate",
                       "a move or a step of an axis, a circle or a corner of two, with "
                       "the controller");
  simulate
      .AddOption("profile", o->profile,
                 "drive profile: a supplied one, or a file .textproto")
      .Require();
  simulate.AddOption("--axis", o->axis, "its name, default the first");
  simulate.AddOption("--length", o->length_mm, "of the move, mm")
      .Positive()
      .ShowDefault();
  simulate.AddOption("--speed", o->speed_mm_s, "mm/s").Positive().ShowDefault();
  simulate.AddOption("--acceleration", o->acceleration_mm_s2, "mm/s^2")
      .Positive()
      .ShowDefault();
  simulate.AddOption("--rest", o->rest_s, "seconds after the move")
      .Positive()
      .ShowDefault();
  simulate
      .AddOption("--load", o->load_nm,
                 "constant torque at the motor, Nm, against the direction +")
      .ShowDefault();
  simulate.AddOption("--circle", o->circle_mm,
                     "the first two axes turn a circle of this radius, mm, at --speed");
  simulate.AddOption("--turns", o->turns, "of the circle").ShowDefault();
  simulate.AddOption(
      "--corner", o->corner_deg,
      "the first two axes go --length, turn by this angle, degrees, and go "
      "as far again");
  simulate.AddFlag("--stop-at-corner", o->stops,
                   "the command rests at the corner; default: at full speed");
  simulate.AddFlag("--step", o->step, "the setpoint jumps by --length");
  simulate.AddFlag("--ideal", o->ideal, "no quantization, no limit, no friction");
  simulate.AddFlag("--json", o->json, "the figures for programs");
  simulate.AddOption("--csv", o->csv, "table of all samples");
  simulate.AddOption("--picture", o->picture, "PNG: speed over time, of a step position");
  simulate.SetFooter(
      "Example: intaglio drive simulate deploy/drives/tirnovean-2016.textproto --step "
      "--length 1 --picture step.png\n"
      "Example: intaglio drive simulate deploy/drives/tirnovean-2016.textproto --circle "
      "30 --speed 33.333\n"
      "Exit code: 0 good, 2 wrong input or a loop that is not stable.");
  simulate.SetAction([o] { return SimulateAxis(*o); });
}

}  // namespace intaglio::cli
