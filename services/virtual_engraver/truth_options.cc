#include "services/virtual_engraver/truth_options.h"

#include <chrono>
#include <cmath>

namespace intaglio::virtual_engraver {
namespace {

Vec3 Vec3Of(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

// Trochimczuk 2008, ch. 6.3: the machine shakes above 7.5 m/s^2.
constexpr double kShakesAboveMmS2 = 7500;
constexpr double kMirrorBrakeMmS2 = 2e7;

ServoOptions LoopOf(const TruthServo& truth) {
  ServoOptions servo{
      truth.position_gain_per_s(),     truth.velocity_time_s(),
      truth.derivative_ratio(),        truth.feed_forward_ratio(),
      truth.load_acceleration_mm_s2(), truth.friction_acceleration_mm_s2()};
  if (truth.has_max_acceleration_mm_s2())
    servo.max_acceleration_mm_s2 = truth.max_acceleration_mm_s2();
  return servo;
}

CascadeOptions LoopOf(const TruthCascade& truth) {
  return {truth.position_gain_per_s(), truth.natural_frequency_hz(),
          truth.damping_ratio()};
}

StepperOptions LoopOf(const TruthStepperScrew& truth) {
  StepperOptions stepper{truth.rotor_frequency_hz(), truth.rotor_damping_ratio(),
                         truth.carriage_frequency_hz(), truth.carriage_damping_ratio(),
                         truth.inertia_ratio()};
  if (truth.has_full_step_mm()) stepper.full_step_mm = truth.full_step_mm();
  return stepper;
}

PlanarOptions LoopOf(const TruthPlanar& truth) {
  PlanarOptions planar{truth.natural_frequency_hz(), truth.damping_ratio(),
                       truth.integral_rate_per_s()};
  if (truth.has_period_s()) planar.period_s = truth.period_s();
  if (truth.has_tooth_period_mm()) planar.tooth_period_mm = truth.tooth_period_mm();
  planar.cogging_mm_s2 = truth.cogging_acceleration_mm_s2();
  planar.sensor_error_mm = truth.sensor_error_um() / 1000;
  return planar;
}

/// Options of a stage, or of one of its axes.
template <typename Truth>
void SetMechanics(const Truth& truth, MechanicsOptions& mechanics) {
  if (truth.has_first_order_lag_s()) mechanics.lag_s = truth.first_order_lag_s();
  if (truth.has_second_order()) {
    mechanics.second_order =
        SecondOrderOptions{truth.second_order().natural_frequency_hz(),
                           truth.second_order().damping_ratio()};
  }
  if (truth.has_servo()) mechanics.loop = LoopOf(truth.servo());
  if (truth.has_cascade()) mechanics.loop = LoopOf(truth.cascade());
  if (truth.has_stepper_screw()) mechanics.loop = LoopOf(truth.stepper_screw());
  if (truth.has_planar()) mechanics.loop = LoopOf(truth.planar());
}

void SetAxisDrives(const TruthStage& truth, MechanicsOptions& mechanics) {
  if (truth.axis_drives().empty()) return;
  const MechanicsOptions of_all = mechanics;
  mechanics.of_axis = {of_all, of_all, of_all};
  for (const TruthAxisDrive& drive : truth.axis_drives()) {
    MechanicsOptions& of = mechanics.of_axis.at(drive.axis() - 1);
    of = {};
    SetMechanics(drive, of);
  }
}

void SetStage(const TruthStage& truth, StageOptions& stage) {
  if (truth.has_travel_min_mm()) stage.travel_min_mm = Vec3Of(truth.travel_min_mm());
  if (truth.has_travel_max_mm()) stage.travel_max_mm = Vec3Of(truth.travel_max_mm());
  if (truth.has_start_mm()) stage.start_mm = Vec3Of(truth.start_mm());
  SetMechanics(truth, stage.mechanics);
  SetAxisDrives(truth, stage.mechanics);
  stage.mechanics.steps_per_mm = Vec3Of(truth.steps_per_mm());
  if (truth.has_vibration()) {
    const TruthVibration& vibration = truth.vibration();
    stage.vibration = VibrationOptions{
        vibration.has_above_mm_s2() ? vibration.above_mm_s2() : kShakesAboveMmS2,
        vibration.natural_frequency_hz(), vibration.damping_ratio()};
  }
  if (truth.has_brake_acceleration_mm_s2())
    stage.brake_acceleration_mm_s2 = truth.brake_acceleration_mm_s2();
  if (truth.has_position_tolerance_um())
    stage.position_tolerance_mm = truth.position_tolerance_um() / 1000;
  stage.repeatability_mm = truth.repeatability_um() / 1000;
  stage.backlash_mm = Vec3Of(truth.backlash_um()) / 1000;
  if (truth.has_serial_number()) stage.serial_number = truth.serial_number();
  stage.floats_on_air = truth.compressed_air();
}

Guide GuideOf(const TruthGuide& truth) {
  return {truth.carries_block(), truth.backwards(),
          truth.has_travel_ratio() ? truth.travel_ratio() : 1, truth.turn_rad()};
}

FieldDeviations DeviationsOf(const TruthDeviations& truth) {
  constexpr double kMmPerNm = 1e-6;
  FieldDeviations deviations{
      truth.pitch_mm(), static_cast<int>(truth.nodes_a_side()), {}};
  for (int i = 0; i < truth.x_nm_size(); ++i)
    deviations.values_mm.emplace_back(kMmPerNm * truth.x_nm(i), kMmPerNm * truth.y_nm(i));
  return deviations;
}

PositionerOptions PositionerOf(const TruthPositioner& truth) {
  PositionerOptions positioner;
  positioner.guides = {GuideOf(truth.x()), GuideOf(truth.y()), GuideOf(truth.z())};
  positioner.has_arm = truth.has_arm();
  positioner.pivot_distance_mm = truth.arm().pivot_distance_mm();
  positioner.arm_length_mm = truth.arm().arm_length_mm();
  positioner.has_mirrors = truth.has_mirrors();
  const TruthMirrors& mirrors = truth.mirrors();
  if (mirrors.has_pupil_x_mm()) positioner.pupil_mm.x() = mirrors.pupil_x_mm();
  if (mirrors.has_pupil_y_mm()) positioner.pupil_mm.y() = mirrors.pupil_y_mm();
  positioner.distortion_ratio = mirrors.distortion_ratio();
  if (mirrors.has_deviations())
    positioner.deviations = DeviationsOf(mirrors.deviations());
  return positioner;
}

BlockStageOptions BlockStageOf(const TruthBlockStage& truth) {
  BlockStageOptions options;
  options.travel_min_mm = Vec3Of(truth.travel_min_mm()).head<2>();
  options.travel_max_mm = Vec3Of(truth.travel_max_mm()).head<2>();
  if (truth.has_max_speed_mm_s()) options.max_speed_mm_s = truth.max_speed_mm_s();
  if (truth.has_acceleration_mm_s2())
    options.acceleration_mm_s2 = truth.acceleration_mm_s2();
  return options;
}

void SetSignals(const TruthLaser& truth, LaserSignals& signals) {
  signals.trigger_shift_us = truth.trigger_shift_us();
  if (truth.has_trigger_max_delay_us())
    signals.trigger_max_delay_us = truth.trigger_max_delay_us();
  if (truth.has_trigger_min_width_us())
    signals.trigger_min_width_us = truth.trigger_min_width_us();
  if (truth.has_sync_width_us()) signals.sync_width_us = truth.sync_width_us();
  if (truth.has_sensor_width_us()) signals.sensor_width_us = truth.sensor_width_us();
  signals.shutter_time_s = truth.shutter_time_ms() / 1000;
}

void SetLaser(const TruthLaser& truth, MachineOptions& options) {
  SetSignals(truth, options.laser.signals);
  LaserOptions& laser = options.laser;
  if (!truth.rates_hz().empty())
    laser.rates_hz.assign(truth.rates_hz().begin(), truth.rates_hz().end());
  if (truth.has_warm_up_s()) laser.warm_up_s = truth.warm_up_s();
  if (truth.has_channels()) laser.channels = static_cast<std::uint8_t>(truth.channels());
  if (truth.has_serial_number()) laser.serial_number = truth.serial_number();
  for (int i = 0; i < truth.channel_offset_mm_size(); ++i) {
    options.channel_offset_mm.at(static_cast<std::size_t>(i) + 1) =
        Vec3Of(truth.channel_offset_mm(i));
  }
  if (truth.has_pulse_energy_mj()) laser.max_energy_mj = truth.pulse_energy_mj();
  if (truth.has_min_pulse_energy_mj()) laser.min_energy_mj = truth.min_pulse_energy_mj();
  if (truth.has_energy_spread_ratio())
    laser.energy_spread_ratio = truth.energy_spread_ratio();
  laser.energy_error_ratio = truth.energy_error_ratio();
  laser.locks_door = truth.door_lock();
  laser.output_count = truth.outputs();
  laser.inputs.assign(truth.inputs().begin(), truth.inputs().end());
  if (truth.has_split_ratio()) options.split_ratio = truth.split_ratio();
}

void SetBlock(const TruthBlock& truth, BlockInMachine& block) {
  if (truth.has_size_mm()) block.size_mm = Vec3Of(truth.size_mm());
  if (truth.has_origin_mm()) block.origin_mm = Vec3Of(truth.origin_mm());
  if (truth.has_refractive_index()) block.refractive_index = truth.refractive_index();
  if (truth.has_numerical_aperture())
    block.numerical_aperture = truth.numerical_aperture();
}

HangingBody HangingBodyOf(const TruthBody& truth) {
  HangingBody body{truth.above_focus_mm()};
  if (truth.has_diameter_mm()) body.radius_mm = truth.diameter_mm() / 2;
  return body;
}

BodyOptions BodiesOf(const MachineTruth& truth) {
  BodyOptions bodies;
  if (truth.has_lens()) bodies.lens = HangingBodyOf(truth.lens());
  if (truth.has_lens_carrier()) bodies.carrier = HangingBodyOf(truth.lens_carrier());
  for (const TruthObstacle& obstacle : truth.obstacles()) {
    bodies.obstacles.push_back({Vec3Of(obstacle.min_mm()), Vec3Of(obstacle.max_mm())});
  }
  return bodies;
}

std::vector<StationInMachine> StationsOf(const TruthBlock& truth) {
  std::vector<StationInMachine> stations;
  for (const TruthStation& station : truth.stations())
    stations.push_back({Vec3Of(station.offset_mm()), station.turn_rad()});
  return stations;
}

}  // namespace

MachineOptions OptionsOf(const MachineTruth& truth) {
  MachineOptions options;
  SetStage(truth.stage(), options.stage);
  SetLaser(truth.laser(), options);
  SetBlock(truth.block(), options.block);
  options.further_stations = StationsOf(truth.block());
  options.bodies = BodiesOf(truth);
  options.positioner = PositionerOf(truth.stage().positioner());
  if (truth.stage().has_block_stage()) {
    const TruthBlockStage& block_stage = truth.stage().block_stage();
    options.stage.block_stage = BlockStageOf(block_stage);
    options.positioner.block_guides = {GuideOf(block_stage.x()),
                                       GuideOf(block_stage.y())};
  }
  const TruthMirrors& mirrors = truth.stage().positioner().mirrors();
  if (mirrors.has_wavelength_nm()) options.wavelength_mm = 1e-6 * mirrors.wavelength_nm();
  options.crack_energy_mj = mirrors.crack_energy_mj();
  if (options.positioner.has_mirrors) {
    options.stage.velocity_unit_nm_s = 100;
    options.stage.mirror_brake_mm_s2 = mirrors.has_brake_acceleration_mm_s2()
                                           ? mirrors.brake_acceleration_mm_s2()
                                           : kMirrorBrakeMmS2;
  }
  const BlockInMachine& block = options.block;
  options.stage.focus_per_axis_unit_mm = FocusPerAxisUnitMm(
      options.positioner, {block.origin_mm, block.origin_mm + block.size_mm});
  options.line_jitter =
      std::chrono::nanoseconds(std::llround(1e6 * truth.line_jitter_ms()));
  if (truth.block().has_crack_length_mm())
    options.crack_length_mm = truth.block().crack_length_mm();
  options.seed = options.stage.repeatability_seed = options.laser.seed = truth.seed();
  if (truth.stage().has_clock_drift_ppm()) {
    options.stage.own_clock = OwnClockOptions{
        truth.stage().clock_drift_ppm(), 1e-3 * truth.line_jitter_ms(), 1, truth.seed()};
  }
  return options;
}

}  // namespace intaglio::virtual_engraver
