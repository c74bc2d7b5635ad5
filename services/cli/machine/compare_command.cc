// `intaglio machine compare`: what positioners do with the same block, the same path and
// the same force.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/machine/stiffness.h"
#include "proto/machine_report.pb.h"
#include "services/cli/json/print_json.h"
#include "services/cli/machine/machine_command.h"
#include "services/cli/offline/offline_steps.h"
#include "services/cli/offline/path_figures.h"
#include "services/cli/offline/path_job.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/machine_room.h"
#include "services/job/models/read_limits.h"

namespace intaglio::cli {
namespace {

struct CompareOptions {
  std::vector<std::string> profiles;
  std::vector<double> block_mm = {50, 50, 30};
  std::string path, materials_db;
  double force_n = 10;
  double rate_hz = 100;
  bool json = false;
};

constexpr double kUmPerMm = 1000;
/// Places of the block that are compared, each way.
constexpr int kGrid = 11;

/// A spiral over a ball in the middle of the block, a third as large as it, 1 mm from
/// point to point: no positioner's own direction is preferred.
PointList SpiralIn(const Vec3& block_mm) {
  constexpr double kSpacingMm = 1;
  const double radius_mm = block_mm.minCoeff() / 3;
  const int count = static_cast<int>(4 * std::numbers::pi * radius_mm * radius_mm /
                                     (kSpacingMm * kSpacingMm));
  const double turns = std::sqrt(std::numbers::pi * count) / 2;
  PointList points;
  for (int i = 0; i < count; ++i) {
    const double height = -1 + 2 * (i + 0.5) / count;
    const double from_axis = std::sqrt(1 - height * height);
    const double angle = 2 * turns * std::acos(-height);
    points.push_back(block_mm / 2 + radius_mm * Vec3(from_axis * std::cos(angle),
                                                     from_axis * std::sin(angle),
                                                     height));
  }
  return points;
}

Result<PointList> PathOf(const CompareOptions& options) {
  const Vec3 block_mm(options.block_mm[0], options.block_mm[1], options.block_mm[2]);
  if (options.path.empty()) return SpiralIn(block_mm);
  auto table = INTAGLIO_TRY(ReadPoints(options.path, ReadLimitsTimes(1).points));
  return std::move(table.points_mm);
}

bool IsPlanar(const MachineSpec& machine) {
  return machine.drive_case() == MachineSpec::kPlanarDrive;
}

/// Both of the first two axes, N/mm or N mm/rad; none: the profile does not have them.
std::optional<Vec2> StiffnessOf(const MachineSpec& machine) {
  if (machine.has_polar()) {
    const PolarKinematics& polar = machine.polar();
    if (!polar.arm().has_stiffness_nm_rad() || !polar.table().has_stiffness_nm_rad())
      return std::nullopt;
    return Vec2(polar.arm().stiffness_nm_rad(), polar.table().stiffness_nm_rad()) *
           kUmPerMm;
  }
  if (!machine.x().has_stiffness_n_um() || !machine.y().has_stiffness_n_um())
    return std::nullopt;
  return Vec2(machine.x().stiffness_n_um(), machine.y().stiffness_n_um()) * kUmPerMm;
}

void NamePositioner(const MachineSpec& machine, ComparedMachine& of) {
  of.set_machine(machine.name());
  of.set_positioner(machine.has_polar()             ? "arm and table"
                    : machine.has_head_over_block() ? "mirrors and lens"
                    : IsPlanar(machine)             ? "planar drive"
                                                    : "screw table");
  of.set_rule(machine.has_polar() ? "(138)" : IsPlanar(machine) ? "(137)" : "(136)");
  of.set_repeatability_um(machine.repeatability_um());
}

machine::StiffnessRule RuleOf(const MachineSpec& machine) {
  if (machine.has_polar()) return machine::StiffnessRule::kParallel;
  return IsPlanar(machine) ? machine::StiffnessRule::kIndependent
                           : machine::StiffnessRule::kSeries;
}

/// Scale and stiffness over a grid of places halfway up the block.
Status CompareStatics(const FrozenJob& job, double force_n, ComparedMachine& of) {
  const machine::AxesFromGlass axes_from_glass = AxesFromGlassOf(job);
  const machine::Kinematics& kinematics = axes_from_glass.kinematics();
  const auto stiffness = StiffnessOf(job.machine());
  const Vec3 block_mm = BlockSizeOf(job.job());
  Vec3 near = AxisLimitsOf(job.machine()).travel_mm.center_mm();
  double weakest_n_mm = std::numeric_limits<double>::infinity();
  of.set_min_scale_mm(std::numeric_limits<double>::infinity());
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Vec3 at_mm(block_mm.x() * (i % kGrid) / (kGrid - 1),
                     block_mm.y() * (i / kGrid) / (kGrid - 1), block_mm.z() / 2);
    near = INTAGLIO_TRY(axes_from_glass.ToAxes(at_mm, near));
    const machine::PlaneScale scale = machine::PlaneScaleAt(kinematics, near);
    of.set_min_scale_mm(std::min(of.min_scale_mm(), scale.min_mm));
    of.set_max_scale_mm(std::max(of.max_scale_mm(), scale.max_mm));
    if (!stiffness) continue;
    weakest_n_mm =
        std::min(weakest_n_mm, machine::WeakestStiffness(kinematics, near, *stiffness));
  }
  if (!stiffness) return {};
  const Vec3 unit_mm = ScaleBoundsOf(job).axis_mm;
  const double first = (*stiffness)[0] / (unit_mm[0] * unit_mm[0] * kUmPerMm);
  const double second = (*stiffness)[1] / (unit_mm[1] * unit_mm[1] * kUmPerMm);
  of.set_first_n_um(first);
  of.set_second_n_um(second);
  of.set_source_stiffness_n_um(
      machine::SourceStiffness(RuleOf(job.machine()), first, second));
  of.set_weakest_n_um(weakest_n_mm / kUmPerMm);
  of.set_deflection_um(force_n / of.weakest_n_um());
  return {};
}

Status CompareMotion(const FrozenJob& job, const PointList& path_mm,
                     ComparedMachine& of) {
  INTAGLIO_TRY(RequireInBlock(job, path_mm));
  const motion::Limits limits = GlassLimitsOf(job);
  of.set_speed_mm_s(limits.max_speed_mm_s.minCoeff());
  of.set_acceleration_mm_s2(limits.max_acceleration_mm_s2.minCoeff());
  const PointList axes = INTAGLIO_TRY(machine::AxesAlong(
      AxesFromGlassOf(job), path_mm, AxisLimitsOf(job.machine()).travel_mm));
  const PlannedMotion planned = INTAGLIO_TRY(PlanMotion(job, axes, {}, {}));
  of.set_ticks(planned.ticks());
  of.set_time_s(planned.machining_time_s());
  of.set_utilisation(planned.utilisation());
  if (planned.has_predicted_max_error_um())
    of.set_predicted_max_error_um(planned.predicted_max_error_um());
  return {};
}

Result<ComparedMachine> CompareOne(const CompareOptions& options,
                                   const std::string& profile, const PointList& path_mm) {
  JobFlags flags;
  flags.machine = profile;
  flags.block_mm = options.block_mm;
  flags.rate_hz = options.rate_hz;
  const FrozenJob job = INTAGLIO_TRY(BuildPathJob(flags, path_mm, options.materials_db));
  ComparedMachine of;
  NamePositioner(job.machine(), of);
  const Vec2 room_mm = RoomOf(job.machine(), BlockSizeOf(job.job()));
  of.set_room_x_mm(room_mm.x());
  of.set_room_y_mm(room_mm.y());
  INTAGLIO_TRY(CompareStatics(job, options.force_n, of));
  INTAGLIO_TRY(CompareMotion(job, path_mm, of));
  return of;
}

std::string OrDash(bool known, double value) {
  return known ? fmt::format("{:.4g}", value) : "-";
}

void PrintText(const MachineComparison& comparison) {
  constexpr const char* kRow =
      "{:<12} {:<14} {:>9} {:>9} {:>15} {:>9} {:>11} {:>13} {:>15} {:>12} {:>11} {:>9} "
      "{:>11}\n";
  std::cout << fmt::format(kRow, "machine", "positioner", "c1, N/um", "c2, N/um",
                           "source, N/um", "weakest", "yields, um", "repeats, um",
                           "mm per unit", "points/tick", "time, s", "error, um",
                           "room, mm");
  for (const ComparedMachine& of : comparison.machines()) {
    const bool stiff = of.has_weakest_n_um();
    std::cout << fmt::format(
        kRow, of.machine(), of.positioner(), OrDash(stiff, of.first_n_um()),
        OrDash(stiff, of.second_n_um()),
        stiff ? fmt::format("{:.4g} {}", of.source_stiffness_n_um(), of.rule()) : "-",
        OrDash(stiff, of.weakest_n_um()), OrDash(stiff, of.deflection_um()),
        fmt::format("{:g}", of.repeatability_um()),
        fmt::format("{:.3g} to {:.3g}", of.min_scale_mm(), of.max_scale_mm()),
        fmt::format("{:.4f}", of.utilisation()), fmt::format("{:.1f}", of.time_s()),
        OrDash(of.has_predicted_max_error_um(), of.predicted_max_error_um()),
        fmt::format("{:.0f} x {:.0f}", of.room_x_mm(), of.room_y_mm()));
  }
  std::cout << fmt::format(
      "{} at {:g} Hz in a block of {:g} x {:g} x {:g} mm; yields: by {:g} N in "
      "the "
      "weakest direction\n",
      client::GroupedCount(comparison.point_count(), "point"), comparison.rate_hz(),
      comparison.block_mm().x(), comparison.block_mm().y(), comparison.block_mm().z(),
      comparison.force_n());
}

int Compare(const CompareOptions& options) {
  const auto path_mm = PathOf(options);
  if (!path_mm) return Complain(path_mm.error(), client::kExitWrongInput);
  MachineComparison comparison;
  comparison.set_force_n(options.force_n);
  comparison.set_rate_hz(options.rate_hz);
  comparison.set_point_count(path_mm->size());
  comparison.mutable_block_mm()->set_x(options.block_mm[0]);
  comparison.mutable_block_mm()->set_y(options.block_mm[1]);
  comparison.mutable_block_mm()->set_z(options.block_mm[2]);
  for (const std::string& profile : options.profiles) {
    auto compared = CompareOne(options, profile, *path_mm);
    if (!compared) {
      Error error = compared.error();
      error.message = profile + ": " + error.message;
      return Complain(error, client::kExitWrongInput);
    }
    *comparison.add_machines() = std::move(*compared);
  }
  if (options.json) return PrintJson(comparison);
  PrintText(comparison);
  return client::kExitGood;
}

}  // namespace

void AddMachineCompareCommand(command_line::Command machine) {
  auto options = std::make_shared<CompareOptions>();
  command_line::Command compare = machine.AddCommand(
      "compare", "stiffness, accuracy and time of machines with the same block and path");
  compare
      .AddOption("PROFILE", options->profiles,
                 "profiles: files, or names of supplied ones")
      .Require();
  compare.AddOption("--path", options->path,
                    "points in the order of engraving; default a spiral over a ball: " +
                        formats::PointExtensions());
  compare.AddOption("--block", options->block_mm, "mm mm mm, size of the block")
      .TakeValues(3)
      .ShowDefault();
  compare.AddOption("--rate", options->rate_hz, "Hz, rate of the laser").ShowDefault();
  compare.AddOption("--force", options->force_n, "N, on the focus across the beam")
      .Within(0.001, 1e6)
      .ShowDefault();
  compare.AddOption("--materials", options->materials_db,
                    "material base, default the user's");
  compare.AddFlag("--json", options->json, "the figures for programs");
  compare.SetFooter(
      "Stiffness needs stiffness_n_um, or stiffness_nm_rad, of both axes in the profile. "
      "The source's figure is that of its rule (136) to (138); the weakest is that of "
      "the "
      "kinematics.\n"
      "Example: intaglio machine compare els-03 planar polar\n"
      "Exit code: 0 good, 2 wrong input.");
  compare.SetAction([options] { return Compare(*options); });
}

}  // namespace intaglio::cli
