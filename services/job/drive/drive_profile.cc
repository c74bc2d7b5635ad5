#include "services/job/drive/drive_profile.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/platform/fields/field_rules.h"
#include "services/platform/text_format/text_format.h"

namespace intaglio {
namespace {

constexpr int kMaxDepth = 8;

void Add(std::vector<Error>& errors, const std::string& path, const std::string& what) {
  errors.push_back({ErrorCode::kInvalidValue, path + ": " + what, ""});
}

double InertiaOfAll(const DriveAxis& axis, drive::CylinderRule rule) {
  return drive::InertiaOf(ScrewOf(axis), MotorOf(axis), rule).total_kg_m2;
}

}  // namespace

std::vector<Error> CheckDriveProfile(const DriveProfile& profile) {
  std::vector<Error> errors;
  // A message that is left out is as one of zeros.
  for (NumberFault& fault : NumbersOutOfRange(profile, "", AbsentMessages::kChecked))
    errors.push_back(std::move(fault.error));
  if (profile.axes().empty())
    Add(errors, "axes", "is missing; describe one axis or more");
  if (profile.demand().empty()) {
    Add(errors, "demand", "is missing; give what the axes have to do, one phase or more");
  }
  std::set<std::string> names;
  for (int i = 0; i < profile.axes_size(); ++i) {
    const DriveAxis& axis = profile.axes(i);
    const std::string path = fmt::format("axes[{}]", i);
    if (axis.name().empty()) Add(errors, path + ".name", "is missing; name the axis");
    if (!names.insert(axis.name()).second)
      Add(errors, path + ".name",
          fmt::format("{:?} is that of another axis", axis.name()));
    const DrivePanelUnit unit = axis.panel().unit();
    if (unit != DRIVE_PANEL_UNIT_VOLT_PER_MM && unit != DRIVE_PANEL_UNIT_ENCODER_PULSE) {
      Add(errors, path + ".panel.unit",
          "is missing; give DRIVE_PANEL_UNIT_VOLT_PER_MM or "
          "DRIVE_PANEL_UNIT_ENCODER_PULSE: a gain means nothing without its unit");
    }
  }
  return errors;
}

Result<DriveProfile> ParseDriveProfile(std::string_view text, const std::string& name) {
  INTAGLIO_TRY(CheckTextSize(text, name, kMaxDriveProfileBytes,
                             "a drive profile (proto/drive.proto)"));
  DriveProfile profile;
  INTAGLIO_TRY(ParseTextFormat(text, name, kMaxDepth, profile));
  std::string wrong;
  for (const Error& error : CheckDriveProfile(profile))
    wrong += fmt::format("{}{}: {}", wrong.empty() ? "" : "\n", name, error.message);
  if (!wrong.empty()) return Fail(ErrorCode::kInvalidValue, wrong);
  return profile;
}

Result<DriveProfile> ReadDriveProfile(const std::filesystem::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxDriveProfileBytes));
  return ParseDriveProfile(text, file.string());
}

drive::Motor MotorOf(const DriveAxis& axis) {
  const DriveMotor& m = axis.motor();
  return {m.resistance_ohm(), m.torque_constant_nm_a(), m.back_emf_v_s(),
          m.friction_nm_s(),  m.inertia_kg_m2(),        m.rated_torque_nm(),
          m.peak_current_a()};
}

drive::ScrewAxis ScrewOf(const DriveAxis& axis) {
  const DriveScrew& s = axis.screw();
  return {s.mass_kg(),
          s.lead_m(),
          s.friction_ratio(),
          s.efficiency_ratio(),
          s.preload_torque_nm(),
          s.diameter_m(),
          s.length_m(),
          s.density_kg_m3(),
          s.coupling_inertia_kg_m2()};
}

std::vector<drive::DemandPhase> DemandOf(const DriveProfile& profile) {
  std::vector<drive::DemandPhase> phases;
  for (const DrivePhase& p : profile.demand())
    phases.push_back({p.duration_s(), p.acceleration_m_s2(), p.force_n()});
  return phases;
}

drive::VelocityLoop VelocityLoopOf(const DriveAxis& axis, drive::CylinderRule rule) {
  const DriveAmplifier& a = axis.amplifier();
  return drive::CloseVelocityLoop(MotorOf(axis),
                                  {a.gain_v_v(), a.tachometer_v_s(), a.max_control_v()},
                                  InertiaOfAll(axis, rule));
}

double VoltPerStep(const DriveProfile& profile, const DriveAxis& axis) {
  return std::ldexp(axis.amplifier().max_control_v(),
                    1 - static_cast<int>(profile.controller().converter_bits()));
}

drive::PositionLoop PositionLoopOf(const DriveProfile& profile, const DriveAxis& axis) {
  const DrivePanel& panel = axis.panel();
  const auto unit = panel.unit() == DRIVE_PANEL_UNIT_VOLT_PER_MM
                        ? drive::PanelUnit::kVoltPerMm
                        : drive::PanelUnit::kEncoderPulse;
  return drive::FromPanel(
      {panel.proportional(), panel.derivative_s(), unit, VoltPerStep(profile, axis),
       profile.controller().counts_per_m()},
      panel.feed_forward_ratio());
}

drive::SampledAxis SampledAxisOf(const DriveProfile& profile, const DriveAxis& axis,
                                 drive::CylinderRule rule) {
  const drive::VelocityLoop velocity = VelocityLoopOf(axis, rule);
  drive::SampledAxis sampled;
  sampled.speed_per_volt =
      velocity.gain_rad_v_s * axis.screw().lead_m() / (2 * std::numbers::pi);
  sampled.velocity_time_s = velocity.time_s;
  sampled.loop = PositionLoopOf(profile, axis);
  sampled.period_s = profile.controller().period_s();
  sampled.volt_per_step = VoltPerStep(profile, axis);
  sampled.max_volt = axis.amplifier().max_control_v();
  sampled.counts_per_m = profile.controller().counts_per_m();
  const drive::TorqueDemand rub = drive::DemandOf(ScrewOf(axis), MotorOf(axis), rule, {});
  sampled.friction_m_s2 = drive::LoadAcceleration(
      MotorOf(axis), velocity, axis.screw().lead_m(), rub.friction_torque_nm);
  return sampled;
}

drive::TunedAxis TunedAxisOf(const DriveProfile& profile, const DriveAxis& axis,
                             drive::CylinderRule rule) {
  drive::TunedAxis tuned;
  tuned.name = axis.name();
  tuned.velocity = VelocityLoopOf(axis, rule);
  tuned.lead_m = axis.screw().lead_m();
  tuned.amplifier_a_per_v = axis.amplifier().gain_v_v() / axis.motor().resistance_ohm();
  tuned.peak_current_a = axis.motor().peak_current_a();
  const auto phases = DemandOf(profile);
  const drive::MotorSize size =
      drive::SizeMotor(ScrewOf(axis), MotorOf(axis), rule, phases);
  tuned.moving_current_a = size.peak_current_a;
  tuned.load_acceleration_m_s2 = drive::LoadAcceleration(
      MotorOf(axis), tuned.velocity, tuned.lead_m,
      drive::DemandOf(ScrewOf(axis), MotorOf(axis), rule, {}).friction_torque_nm);
  return tuned;
}

}  // namespace intaglio
