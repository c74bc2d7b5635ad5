// `intaglio drive` and `intaglio drive size`: motors against what they have to do.

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <string>

#include "proto/drive_report.pb.h"
#include "services/cli/drive/drive_command.h"
#include "services/cli/flags/drive_profile_flag.h"
#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/drive/drive_profile.h"

namespace intaglio::cli {
namespace {

struct DriveSizeOptions {
  std::string profile;
  bool source_rules = false, json = false;
};

std::string SizeText(const DriveProfile& profile, const DriveAxis& axis,
                     drive::CylinderRule rule) {
  const drive::Motor motor = MotorOf(axis);
  const drive::ScrewAxis screw = ScrewOf(axis);
  const auto phases = DemandOf(profile);
  const drive::MotorSize size = drive::SizeMotor(screw, motor, rule, phases);
  std::string text = fmt::format(
      "axis          {}\n"
      "inertia       {:.6g} kg m^2: screw {:.6g}, load {:.6g}, rotor {:.6g}\n"
      "rated torque  {:.6g} rad/s^2 and {:.6g} m/s^2 alone, {:.6g} rad/s^2 and {:.6g} "
      "m/s^2 loaded\n",
      axis.name(), size.inertia.total_kg_m2, size.inertia.screw_kg_m2,
      size.inertia.load_kg_m2, motor.inertia_kg_m2, size.unloaded.rad_s2,
      size.unloaded.m_s2, size.loaded.rad_s2, size.loaded.m_s2);
  for (const drive::DemandPhase& phase : phases) {
    const drive::TorqueDemand d = drive::DemandOf(screw, motor, rule, phase);
    text += fmt::format(
        "phase         {:g} s, {:g} m/s^2, {:g} N: {:.6g} Nm, {:.4g} A; as Tirnovean "
        "2016 counts {:.6g} Nm\n",
        phase.duration_s, phase.acceleration_m_s2, phase.force_n, d.torque_nm,
        d.current_a, d.torque_2016_nm);
  }
  return text + fmt::format(
                    "torque        {:.6g} Nm peak, {:.6g} Nm rms of rated {:g}: margin "
                    "{:.3g}\n"
                    "current       {:.4g} A peak of {:g}: margin {:.3g}; {:.4g} A rms\n",
                    size.peak_torque_nm, size.rms_torque_nm, motor.rated_torque_nm,
                    size.rated_margin_ratio, size.peak_current_a, motor.peak_current_a,
                    size.peak_margin_ratio, size.rms_current_a);
}

SizedAxis SizedAxisOf(const DriveProfile& profile, const DriveAxis& axis,
                      drive::CylinderRule rule) {
  const drive::Motor motor = MotorOf(axis);
  const drive::ScrewAxis screw = ScrewOf(axis);
  const auto phases = DemandOf(profile);
  const drive::MotorSize size = drive::SizeMotor(screw, motor, rule, phases);
  SizedAxis sized;
  sized.set_axis(axis.name());
  sized.set_inertia_kg_m2(size.inertia.total_kg_m2);
  sized.set_screw_kg_m2(size.inertia.screw_kg_m2);
  sized.set_load_kg_m2(size.inertia.load_kg_m2);
  sized.set_rotor_kg_m2(motor.inertia_kg_m2);
  sized.set_unloaded_m_s2(size.unloaded.m_s2);
  sized.set_loaded_m_s2(size.loaded.m_s2);
  for (const drive::DemandPhase& phase : phases) {
    const drive::TorqueDemand d = drive::DemandOf(screw, motor, rule, phase);
    SizedPhase& of = *sized.add_phases();
    of.set_duration_s(phase.duration_s);
    of.set_acceleration_m_s2(phase.acceleration_m_s2);
    of.set_force_n(phase.force_n);
    of.set_torque_nm(d.torque_nm);
    of.set_current_a(d.current_a);
    of.set_torque_2016_nm(d.torque_2016_nm);
  }
  sized.set_peak_torque_nm(size.peak_torque_nm);
  sized.set_rms_torque_nm(size.rms_torque_nm);
  sized.set_rated_margin_ratio(size.rated_margin_ratio);
  sized.set_peak_current_a(size.peak_current_a);
  sized.set_rms_current_a(size.rms_current_a);
  sized.set_peak_margin_ratio(size.peak_margin_ratio);
  return sized;
}

/// Whether each motor bears its demand.
bool IsEnough(const DriveProfile& profile, drive::CylinderRule rule) {
  const auto phases = DemandOf(profile);
  for (const DriveAxis& axis : profile.axes()) {
    const auto size = drive::SizeMotor(ScrewOf(axis), MotorOf(axis), rule, phases);
    const bool heats = size.rms_torque_nm > axis.motor().rated_torque_nm();
    if (heats || size.peak_current_a > axis.motor().peak_current_a()) return false;
  }
  return true;
}

int Size(const DriveSizeOptions& options) {
  const auto profile = NamedDriveProfile(options.profile);
  if (!profile) return Complain(profile.error(), client::kExitWrongInput);
  const auto rule = options.source_rules ? drive::CylinderRule::kTirnovean2016
                                         : drive::CylinderRule::kSolid;
  const bool enough = IsEnough(*profile, rule);
  const int code = enough ? client::kExitGood : client::kExitNotGood;
  if (options.json) {
    DriveSizes sizes;
    for (const DriveAxis& axis : profile->axes())
      *sizes.add_axes() = SizedAxisOf(*profile, axis, rule);
    sizes.set_enough(enough);
    const int failed = PrintJson(sizes);
    return failed != client::kExitGood ? failed : code;
  }
  for (const DriveAxis& axis : profile->axes())
    std::cout << SizeText(*profile, axis, rule);
  std::cout << (enough ? "verdict       the motors bear the demand\n"
                       : "verdict       a motor does not bear the demand\n");
  return code;
}

}  // namespace

void AddDriveSizeCommand(command_line::Command drive) {
  auto options = std::make_shared<DriveSizeOptions>();
  command_line::Command size =
      drive.AddCommand("size", "torques, currents and margins of the motors");
  size.AddOption("profile", options->profile,
                 "drive profile: a supplied one, or a file .textproto")
      .Require();
  size.AddFlag("--source-rules", options->source_rules,
               "the screw's inertia as printed in Tirnovean 2016, twice a solid one's");
  size.AddFlag("--json", options->json, "the figures for programs");
  size.SetFooter(
      "Example: intaglio drive size deploy/drives/tirnovean-2016.textproto\n"
      "Exit code: 0 good, 2 wrong input, 3 a motor does not bear the demand.");
  size.SetAction([options] { return Size(*options); });
}

void AddDriveCommand(command_line::Command app) {
  command_line::Command drive =
      app.AddCommand("drive", "what the drives of a machine can do");
  drive.RequireCommand();
  drive.SetFooter(
      "Example: intaglio drive size deploy/drives/tirnovean-2016.textproto\n"
      "docs/machines/drives.md explains profile and figures.");
  AddDriveSizeCommand(drive);
  AddDriveTuneCommands(drive);
  AddDriveSimulateCommand(drive);
  AddDriveIdentifyCommand(drive);
  AddDriveCornerCommand(drive);
  AddDriveCircleCommand(drive);
}

}  // namespace intaglio::cli
