#include "services/client/shop/virtual_truth.h"

#include <google/protobuf/message.h>

#include <algorithm>

#include "services/client/proof/marks/cut_evidence.h"
#include "services/job/fields/shapes.h"
#include "services/job/head/field_table.h"
#include "services/job/machine/accessories.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/head_clearance.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/laser_setting.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/stations.h"

namespace intaglio::client {
namespace {

Vector3 Vector(double x, double y, double z) {
  Vector3 v;
  v.set_x(x);
  v.set_y(y);
  v.set_z(z);
  return v;
}

TruthGuide GuideOf(const machine::LinearAxis& axis) {
  TruthGuide guide;
  guide.set_carries_block(axis.moves_table);
  guide.set_backwards(axis.reversed);
  if (axis.scale_ratio != 1) guide.set_travel_ratio(axis.scale_ratio);
  return guide;
}

// The steps of a stepper are not in the profile: so long ones that none is lost.
constexpr double kFullStepMm = 10;
// A calibration may begin at 0, which is no pulse.
constexpr double kMinEnergy_mj = 0.001;

/// The fields of `from` into those of the same names.
void SetEqualFields(const google::protobuf::Message& from,
                    google::protobuf::Message& to) {
  for (int i = 0; i < from.GetDescriptor()->field_count(); ++i) {
    const auto* field = from.GetDescriptor()->field(i);
    to.GetReflection()->SetDouble(&to, to.GetDescriptor()->FindFieldByName(field->name()),
                                  from.GetReflection()->GetDouble(from, field));
  }
}

/// The ways of the beam in the field: y is turned back from a right angle to x.
void SetFieldShape(const FieldShape& field, TruthPositioner& positioner) {
  if (field.has_x_scale_ratio())
    positioner.mutable_x()->set_travel_ratio(field.x_scale_ratio());
  if (field.has_y_scale_ratio())
    positioner.mutable_y()->set_travel_ratio(field.y_scale_ratio());
  if (field.rotation_rad() != 0)
    positioner.mutable_x()->set_turn_rad(field.rotation_rad());
  const double y_turn_rad = field.rotation_rad() - field.squareness_xy_rad();
  if (y_turn_rad != 0) positioner.mutable_y()->set_turn_rad(y_turn_rad);
}

/// The field that these corrections make up for.
void SetDeviations(const galvo::CorrectionTable& corrections, TruthMirrors& mirrors) {
  constexpr int kNodes = 65;
  // A profile that is checked has an inverse.
  const auto grid = galvo::CommandGrid(corrections, kNodes);
  if (!grid) return;
  const FieldTable table = FieldTableOf(*grid);
  TruthDeviations& deviations = *mirrors.mutable_deviations();
  deviations.set_pitch_mm(table.pitch_mm());
  deviations.set_nodes_a_side(table.nodes_a_side());
  *deviations.mutable_x_nm() = table.x_nm();
  *deviations.mutable_y_nm() = table.y_nm();
}

/// What the axes carry.
TruthPositioner PositionerOf(const MachineSpec& machine) {
  TruthPositioner positioner;
  const machine::KinematicsOptions kinematics = KinematicsOptionsOf(machine);
  if (const auto* polar = std::get_if<machine::PolarOptions>(&kinematics)) {
    positioner.mutable_arm()->set_pivot_distance_mm(polar->axis_distance_mm);
    positioner.mutable_arm()->set_arm_length_mm(polar->arm_length_mm);
    *positioner.mutable_z() = GuideOf(polar->z);
    return positioner;
  }
  if (const auto* head = std::get_if<machine::ScanHeadOptions>(&kinematics)) {
    TruthMirrors& mirrors = *positioner.mutable_mirrors();
    if (!head->lens.is_telecentric()) {
      mirrors.set_pupil_x_mm(head->lens.pupil_mm.x());
      mirrors.set_pupil_y_mm(head->lens.pupil_mm.y());
    }
    mirrors.set_brake_acceleration_mm_s2(std::min(machine.x().max_acceleration_mm_s2(),
                                                  machine.y().max_acceleration_mm_s2()));
    mirrors.set_wavelength_nm(machine.laser().wavelength_nm());
    mirrors.set_crack_energy_mj(CrackEnergyMj(machine));
    *positioner.mutable_z() = GuideOf(head->z);
    SetFieldShape(machine.head_over_block().field(), positioner);
    if (head->corrections) SetDeviations(*head->corrections, mirrors);
    return positioner;
  }
  const auto& linear = std::get<machine::CartesianOptions>(kinematics);
  *positioner.mutable_x() = GuideOf(linear.x);
  *positioner.mutable_y() = GuideOf(linear.y);
  *positioner.mutable_z() = GuideOf(linear.z);
  if (linear.squareness_xy_rad != 0) {
    positioner.mutable_y()->set_turn_rad(-linear.squareness_xy_rad);
  }
  return positioner;
}

/// One that the profile is right for.
void SetBlockStage(const BlockStage& profile, TruthBlockStage& truth) {
  TruthGuide &x = *truth.mutable_x(), &y = *truth.mutable_y();
  if (profile.has_x_scale_ratio()) x.set_travel_ratio(profile.x_scale_ratio());
  if (profile.has_y_scale_ratio()) y.set_travel_ratio(profile.y_scale_ratio());
  x.set_turn_rad(profile.rotation_rad());
  y.set_turn_rad(profile.rotation_rad() - profile.squareness_xy_rad());
  *truth.mutable_travel_min_mm() =
      Vector(profile.x().travel_min_mm(), profile.y().travel_min_mm(), 0);
  *truth.mutable_travel_max_mm() =
      Vector(profile.x().travel_max_mm(), profile.y().travel_max_mm(), 0);
  truth.set_max_speed_mm_s(
      std::min(profile.x().max_speed_mm_s(), profile.y().max_speed_mm_s()));
  truth.set_acceleration_mm_s2(std::min(profile.x().max_acceleration_mm_s2(),
                                        profile.y().max_acceleration_mm_s2()));
}

/// Copies from a machine into a stage, or from an axis into an axis.
template <typename Profile, typename Truth>
void SetDrive(const Profile& profile, Truth& truth) {
  switch (profile.drive_case()) {
    case Profile::kSecondOrder:
      return SetEqualFields(profile.second_order(), *truth.mutable_second_order());
    case Profile::kServo:
      return SetEqualFields(profile.servo(), *truth.mutable_servo());
    case Profile::kCascade:
      return SetEqualFields(profile.cascade(), *truth.mutable_cascade());
    case Profile::kStepperScrew:
      SetEqualFields(profile.stepper_screw(), *truth.mutable_stepper_screw());
      return truth.mutable_stepper_screw()->set_full_step_mm(kFullStepMm);
    case Profile::kPlanarDrive:
      return SetEqualFields(profile.planar_drive(), *truth.mutable_planar());
    case Profile::kStageLagS:
    case Profile::DRIVE_NOT_SET:
      break;
  }
  truth.set_first_order_lag_s(profile.stage_lag_s());
}

void SetAxisDrives(const MachineSpec& machine, TruthStage& stage) {
  const auto axes = KinematicsOf(machine)->axes();
  for (const AxisDrive& drive : machine.axis_drives()) {
    const auto axis = std::ranges::find(axes, drive.axis(), &machine::Axis::name);
    TruthAxisDrive& truth = *stage.add_axis_drives();
    truth.set_axis(static_cast<std::uint32_t>(axis - axes.begin()) + 1);
    SetDrive(drive, truth);
  }
}

void SetSteps(const MachineSpec& machine, TruthStage& stage) {
  const Vec3 steps = StepsPerMm(machine);
  if (!steps.isZero(0))
    *stage.mutable_steps_per_mm() = Vector(steps.x(), steps.y(), steps.z());
}

void SetStage(const MachineSpec& machine, TruthStage& stage) {
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  *stage.mutable_travel_min_mm() =
      Vector(travel.min_mm.x(), travel.min_mm.y(), travel.min_mm.z());
  *stage.mutable_travel_max_mm() =
      Vector(travel.max_mm.x(), travel.max_mm.y(), travel.max_mm.z());
  *stage.mutable_positioner() = PositionerOf(machine);
  if (machine.head_over_block().has_block_stage()) {
    SetBlockStage(machine.head_over_block().block_stage(), *stage.mutable_block_stage());
  }
  SetDrive(machine, stage);
  SetAxisDrives(machine, stage);
  SetSteps(machine, stage);
  stage.set_compressed_air(machine.compressed_air());
  stage.set_position_tolerance_um(machine.position_tolerance_um());
  if (machine.motion_line().has_serial_number())
    stage.set_serial_number(machine.motion_line().serial_number());
}

/// A laser that the profile is right for.
void SetSignals(const PulseTiming& timing, TruthLaser& laser) {
  if (timing.has_max_qswitch_delay_us())
    laser.set_trigger_max_delay_us(timing.max_qswitch_delay_us());
  if (timing.has_min_qswitch_width_us())
    laser.set_trigger_min_width_us(timing.min_qswitch_width_us());
  if (timing.has_min_sync_width_us())
    laser.set_sync_width_us(1 + timing.min_sync_width_us());
  if (timing.has_min_sensor_width_us())
    laser.set_sensor_width_us(1 + timing.min_sensor_width_us());
  if (timing.has_shutter_time_ms()) laser.set_shutter_time_ms(timing.shutter_time_ms());
}

void SetLaser(const MachineSpec& machine, TruthLaser& laser) {
  SetSignals(machine.laser().timing(), laser);
  laser.set_door_lock(machine.laser().door_lock());
  laser.set_outputs(OutputCountOf(machine));
  for (const bool on : InputsAsNeeded(machine)) laser.add_inputs(on);
  if (machine.laser().has_split_ratio())
    laser.set_split_ratio(machine.laser().split_ratio());
  *laser.mutable_rates_hz() = machine.laser().rates_hz();
  laser.set_warm_up_s(machine.laser().warm_up_s());
  laser.set_channels(machine.laser().channels());
  laser.set_pulse_energy_mj(machine.laser().pulse_energy_mj());
  if (const auto calibrated = EnergiesOf(machine.laser()))
    laser.set_min_pulse_energy_mj(std::max(kMinEnergy_mj, calibrated->min_mj));
  if (!machine.channel_positions().empty()) {
    for (std::uint32_t channel = 2; channel <= 4; ++channel) {
      const Vec3 mm = FocusOffsetOf(machine, "", channel);
      *laser.add_channel_offset_mm() = Vector(mm.x(), mm.y(), mm.z());
    }
  }
  if (machine.laser_line().has_serial_number())
    laser.set_serial_number(machine.laser_line().serial_number());
}

/// Blocks at all stations.
void SetStations(const MachineSpec& machine, TruthBlock& block) {
  for (std::uint32_t number = 2; number <= StationCountOf(machine); ++number) {
    const StationPlace place = StationPlaceOf(machine, number);
    TruthStation& station = *block.add_stations();
    *station.mutable_offset_mm() =
        Vector(place.offset_mm.x(), place.offset_mm.y(), place.offset_mm.z());
    station.set_turn_rad(place.turn_rad);
  }
}

/// What hangs around the beam. A lens of unknown size is at its focal length, as thin as
/// one can be.
void SetBodies(const MachineSpec& machine, const MachineLens& lens, MachineTruth& truth) {
  truth.mutable_lens()->set_above_focus_mm(FreeDistanceMm(lens));
  if (lens.has_mount_diameter_mm())
    truth.mutable_lens()->set_diameter_mm(lens.mount_diameter_mm());
  if (machine.has_head_body() && lens.has_working_distance_mm()) {
    TruthBody& carrier = *truth.mutable_lens_carrier();
    carrier.set_above_focus_mm(lens.working_distance_mm() +
                               machine.head_body().above_reference_mm());
    carrier.set_diameter_mm(machine.head_body().diameter_mm());
  }
  for (const Fixture& fixture : machine.fixtures()) {
    TruthObstacle& obstacle = *truth.add_obstacles();
    *obstacle.mutable_min_mm() = fixture.min_mm();
    *obstacle.mutable_max_mm() = fixture.max_mm();
  }
}

/// Where its axes count from, or as far above as its lens is free of the block.
void SetStart(const MachineSpec& machine, MachineTruth& truth) {
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const auto kinematics = KinematicsOf(machine);
  Vec3 axes = Vec3::Zero().cwiseMax(travel.min_mm).cwiseMin(travel.max_mm);
  const TruthBlock& block = truth.block();
  const double free_mm =
      block.origin_mm().z() + block.size_mm().z() - truth.lens().above_focus_mm();
  const double below_mm = free_mm - kinematics->ToPlace(axes).z();
  if (below_mm <= 0) return;
  axes.z() += below_mm / kinematics->ScaleAt(axes)(2, 2);
  axes = axes.cwiseMax(travel.min_mm).cwiseMin(travel.max_mm);
  *truth.mutable_stage()->mutable_start_mm() = Vector(axes.x(), axes.y(), axes.z());
}

/// An ideal head; a truth file of the user has a real one.
void SetHead(const MachineSpec& machine, HeadTruth& head) {
  head.set_field_mm(machine.scan_head().field_mm());
  head.set_servo_lag_s(machine.scan_head().servo_lag_s());
  if (machine.scan_head().encoder_count_um() > 0)
    head.set_encoder_count_um(machine.scan_head().encoder_count_um());
  if (machine.scan_head().has_eye_mm()) head.set_eye_mm(machine.scan_head().eye_mm());
  head.set_serial_number(machine.mark_line().serial_number());
}

}  // namespace

MachineTruth TruthOf(const MachineSpec& machine, const MountedParts& mounted) {
  MachineTruth truth;
  if (machine.has_mark_line()) {
    SetHead(machine, *truth.mutable_head());
    return truth;
  }
  SetStage(machine, *truth.mutable_stage());
  SetLaser(machine, *truth.mutable_laser());
  TruthBlock& block = *truth.mutable_block();
  const Vec3& size_mm = mounted.block_mm.value();
  *block.mutable_size_mm() = Vector(size_mm.x(), size_mm.y(), size_mm.z());
  // The truth is that of the mounted lens: the focus is at the machine's zero with it.
  const MachineLens* lens = FindLens(machine, mounted.lens.value().focal_length_mm);
  const Vec3 origin_mm = Vec3Of(machine.block_origin_mm()) -
                         FocusOffsetOf(machine, lens == nullptr ? "" : lens->name(), 1);
  *block.mutable_origin_mm() = Vector(origin_mm.x(), origin_mm.y(), origin_mm.z());
  block.set_refractive_index(mounted.refractive_index.value());
  block.set_numerical_aperture(mounted.lens.value().numerical_aperture);
  if (lens != nullptr && lens->crack_length_mm() > 0)
    block.set_crack_length_mm(lens->crack_length_mm());
  SetStations(machine, block);
  if (lens == nullptr) return truth;
  SetBodies(machine, *lens, truth);
  SetStart(machine, truth);
  return truth;
}

MachineTruth TruthOfMill(const MachineSpec& machine, const Course& course) {
  MachineTruth truth;
  MillTruth& mill = *truth.mutable_mill();
  mill.set_laser(machine.course_tool().kind() == COURSE_TOOL_LASER);
  mill.set_tool_diameter_mm(ToolDiameterOf(course));
  mill.set_serial_number(machine.mark_line().serial_number());
  return truth;
}

}  // namespace intaglio::client
