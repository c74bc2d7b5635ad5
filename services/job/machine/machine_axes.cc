#include "services/job/machine/machine_axes.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <exception>

#include "engrave/core/check.h"
#include "engrave/optics/focus.h"
#include "services/job/fields/channels.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/stations.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {
namespace {

machine::LinearAxis LinearAxisOf(const LinearAxis& axis) {
  return {axis.moves() == AXIS_MOVES_TABLE, axis.reversed(),
          axis.has_scale_ratio() ? axis.scale_ratio() : 1};
}

machine::PolarOptions PolarOptionsOf(const PolarKinematics& polar) {
  machine::PolarOptions options;
  options.axis_distance_mm = polar.axis_distance_mm();
  options.arm_length_mm = polar.arm_length_mm();
  options.side =
      polar.side() == ARM_SIDE_RIGHT ? machine::ArmSide::kRight : machine::ArmSide::kLeft;
  options.z = LinearAxisOf(polar.z());
  if (polar.has_singular_margin_rad()) {
    options.singular_margin_rad = polar.singular_margin_rad();
  }
  return options;
}

void SetAxis(motion::Limits& limits, int i, const AxisLimits& axis) {
  limits.max_speed_mm_s[i] = axis.max_speed_mm_s();
  limits.max_acceleration_mm_s2[i] = axis.max_acceleration_mm_s2();
  if (axis.has_max_jerk_mm_s3()) limits.max_jerk_mm_s3[i] = axis.max_jerk_mm_s3();
  limits.travel_mm.min_mm[i] = axis.travel_min_mm();
  limits.travel_mm.max_mm[i] = axis.travel_max_mm();
}

void SetAxis(motion::Limits& limits, int i, const RotaryAxis& axis) {
  limits.max_speed_mm_s[i] = axis.max_speed_rad_s();
  limits.max_acceleration_mm_s2[i] = axis.max_acceleration_rad_s2();
  if (axis.has_max_jerk_rad_s3()) limits.max_jerk_mm_s3[i] = axis.max_jerk_rad_s3();
  limits.travel_mm.min_mm[i] = axis.travel_min_rad();
  limits.travel_mm.max_mm[i] = axis.travel_max_rad();
}

void NarrowTravel(motion::Limits& limits, const MachineSpec& machine) {
  if (!machine.taught().has_limits()) return;
  const SoftLimits& soft = machine.taught().limits();
  Box3& travel = limits.travel_mm;
  travel.min_mm = travel.min_mm.cwiseMax(Vec3Of(soft.min()));
  travel.max_mm = travel.max_mm.cwiseMin(Vec3Of(soft.max()));
}

}  // namespace

machine::KinematicsOptions KinematicsOptionsOf(const MachineSpec& machine) {
  if (machine.has_polar()) return PolarOptionsOf(machine.polar());
  if (machine.has_head_over_block()) {
    machine::ScanHeadOptions head = HeadOptionsOf(machine.head_over_block());
    head.z = LinearAxisOf(machine.head_over_block().z());
    return head;
  }
  const CartesianKinematics& cartesian = machine.cartesian();
  return machine::CartesianOptions{
      LinearAxisOf(cartesian.x()), LinearAxisOf(cartesian.y()),
      LinearAxisOf(cartesian.z()), cartesian.squareness_xy_rad()};
}

std::shared_ptr<const machine::Kinematics> KinematicsOf(const MachineSpec& machine) {
  return machine::MakeKinematics(KinematicsOptionsOf(machine));
}

std::shared_ptr<const machine::Kinematics> KinematicsOf(
    const MachineSpec& machine, const JobSpec& job,
    const optics::MachineFromGlass& frame) {
  machine::KinematicsOptions options = KinematicsOptionsOf(machine);
  if (auto* polar = std::get_if<machine::PolarOptions>(&options))
    polar->frame_turn_rad = StationPlaceOf(machine, job).turn_rad;
  if (auto* head = std::get_if<machine::ScanHeadOptions>(&options)) {
    head->top_z_mm = frame.top_z_mm();
    head->refractive_index = optics::RefractiveIndexOf(frame.stage_per_glass_ratio,
                                                       job.lens().numerical_aperture());
  }
  return machine::MakeKinematics(options);
}

bool AreHeadCoordinates(const MachineSpec& machine) {
  const auto kinematics = KinematicsOptionsOf(machine);
  const auto* linear = std::get_if<machine::CartesianOptions>(&kinematics);
  return linear != nullptr && linear->x.per_unit_mm() == 1 &&
         linear->y.per_unit_mm() == 1 && linear->z.per_unit_mm() == 1 &&
         linear->squareness_xy_rad == 0;
}

motion::Limits AxisLimitsOf(const MachineSpec& machine) {
  motion::Limits limits;
  SetAxis(limits, 2, machine.z());
  if (machine.has_polar()) {
    SetAxis(limits, 0, machine.polar().arm());
    SetAxis(limits, 1, machine.polar().table());
    NarrowTravel(limits, machine);
    return limits;
  }
  SetAxis(limits, 0, machine.x());
  SetAxis(limits, 1, machine.y());
  NarrowTravel(limits, machine);
  if (machine.has_max_speed_norm_mm_s()) {
    limits.max_speed_norm_mm_s = machine.max_speed_norm_mm_s();
  }
  if (machine.has_max_acceleration_norm_mm_s2()) {
    limits.max_acceleration_norm_mm_s2 = machine.max_acceleration_norm_mm_s2();
  }
  return limits;
}

namespace {

/// How far the focus goes for a unit of each axis, at most, anywhere.
Vec3 FocusPerAxisUnitMm(const MachineSpec& machine) {
  if (machine.has_polar()) {
    const double arm_mm = machine.polar().arm_length_mm();
    return {arm_mm, machine.polar().axis_distance_mm() + arm_mm, 1};
  }
  if (machine.has_head_over_block()) {
    // A profile that is not checked yet may have a correction without an inverse.
    const Vec2 field = FieldScaleOf(machine.head_over_block().field());
    return {field.x(), field.y(),
            LinearAxisOf(machine.head_over_block().z()).scale_ratio};
  }
  return KinematicsOf(machine)->BoundsOver({Vec3::Zero(), Vec3::Zero()}).axis_mm;
}

}  // namespace

Vec3 StepsPerMm(const MachineSpec& machine) {
  return {machine.x().steps_per_mm(), machine.y().steps_per_mm(),
          machine.z().steps_per_mm()};
}

Vec3 HalfStepsMm(const MachineSpec& machine) {
  const Vec3 steps = StepsPerMm(machine), scale_mm = FocusPerAxisUnitMm(machine);
  Vec3 half_mm = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis)
    if (steps[axis] > 0) half_mm[axis] = scale_mm[axis] / (2 * steps[axis]);
  return half_mm;
}

double HalfStepInGlassMm(const FrozenJob& job) {
  Vec3 half_mm = HalfStepsMm(job.machine());
  if (half_mm.z() > 0) half_mm.z() /= std::min(1.0, job.optics().stage_per_glass_ratio());
  return half_mm.norm();
}

FocusLimits FocusLimitsOf(const MachineSpec& machine) {
  const motion::Limits limits = AxisLimitsOf(machine);
  const Vec3 scale_mm = FocusPerAxisUnitMm(machine);
  return {
      std::min(RangeOf<MotionOptions>(MotionOptions::kMaxSpeedMmSFieldNumber).max,
               limits.max_speed_mm_s.cwiseProduct(scale_mm).maxCoeff()),
      std::min(RangeOf<MotionOptions>(MotionOptions::kMaxAccelerationMmS2FieldNumber).max,
               limits.max_acceleration_mm_s2.cwiseProduct(scale_mm).maxCoeff())};
}

machine::AxesFromGlass AxesFromGlassOf(const FrozenJob& job) {
  const optics::MachineFromGlass frame = MachineFromGlassOf(job);
  return {frame, KinematicsOf(job.machine(), job.job(), frame)};
}

std::optional<machine::AxesFromGlass> AxesFromGlassOfAny(const FrozenJob& job) {
  const Vec3 block_mm = BlockSizeOf(job.job());
  if (!(block_mm.minCoeff() > 0) || !block_mm.allFinite()) return std::nullopt;
  try {
    return AxesFromGlassOf(job);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::vector<machine::AxesFromGlass> AxesFromGlassOfModels(const FrozenJob& job) {
  std::vector<machine::AxesFromGlass> all;
  for (const ChannelMask mask : ChannelsOfModels(job.job())) {
    optics::MachineFromGlass frame = MachineFromGlassOf(job);
    frame.block_origin_mm = BlockOriginOf(job.machine(), job.job(), FirstChannel(mask));
    all.emplace_back(frame, KinematicsOf(job.machine(), job.job(), frame));
  }
  return all;
}

Box3 PartInField(const MachineSpec& machine, const Box3& box_mm, const Vec3& origin_mm) {
  if (!machine.head_over_block().has_block_stage()) return box_mm;
  const Box3 field = AxisLimitsOf(machine).travel_mm;
  Box3 part_mm = box_mm;
  for (int i = 0; i < 2; ++i) {
    part_mm.min_mm[i] = std::max(box_mm.min_mm[i], field.min_mm[i] - origin_mm[i]);
    part_mm.max_mm[i] = std::min(box_mm.max_mm[i], field.max_mm[i] - origin_mm[i]);
  }
  return part_mm;
}

machine::ScaleBounds ScaleBoundsOf(const FrozenJob& job) {
  const optics::MachineFromGlass frame = MachineFromGlassOf(job);
  const Box3 part_mm = PartInField(job.machine(), {Vec3::Zero(), BlockSizeOf(job.job())},
                                   frame.block_origin_mm);
  Box3 places_mm;
  places_mm.Extend(frame.ToMachine(part_mm.min_mm));
  places_mm.Extend(frame.ToMachine(part_mm.max_mm));
  return KinematicsOf(job.machine(), job.job(), frame)->BoundsOver(places_mm);
}

motion::Limits CappedAxisLimitsOf(const FrozenJob& job) {
  const MotionOptions& asked = job.job().motion();
  const Vec3 scale_mm = ScaleBoundsOf(job).axis_mm;
  const motion::Limits own = AxisLimitsOf(job.machine());
  motion::Limits limits;
  limits.travel_mm = own.travel_mm;
  limits.max_speed_mm_s =
      own.max_speed_mm_s.cwiseMin(asked.max_speed_mm_s() * scale_mm.cwiseInverse());
  limits.max_acceleration_mm_s2 = own.max_acceleration_mm_s2.cwiseMin(
      asked.max_acceleration_mm_s2() * scale_mm.cwiseInverse());
  return limits;
}

namespace {

/// The moves of the axes for a millimetre of the focus in air along x, y, z, its columns,
/// in the middle of the block.
Mat3 AxesPerMm(const FrozenJob& job, const motion::Limits& axis_limits) {
  const machine::AxesFromGlass axes_from_glass = AxesFromGlassOf(job);
  const Box3 part_mm = PartInField(job.machine(), {Vec3::Zero(), BlockSizeOf(job.job())},
                                   BlockOriginOf(job.machine(), job.job()));
  const auto middle = axes_from_glass.ToAxes(0.5 * (part_mm.min_mm + part_mm.max_mm),
                                             machine::BranchStart(axis_limits.travel_mm));
  Require(middle.has_value(), "the middle of the block: {}",
          middle ? "" : middle.error().message);
  return axes_from_glass.kinematics().ScaleAt(*middle).inverse();
}

/// How fast the focus goes when it moves the axes by `axes_per_mm`.
FocusLimits FocusLimitsFor(const Vec3& axes_per_mm, const motion::Limits& axis_limits) {
  FocusLimits limits{motion::kUnlimited, motion::kUnlimited};
  for (int axis = 0; axis < 3; ++axis) {
    const double moved = std::abs(axes_per_mm[axis]);
    if (moved == 0) continue;
    limits.speed_mm_s =
        std::min(limits.speed_mm_s, axis_limits.max_speed_mm_s[axis] / moved);
    limits.acceleration_mm_s2 = std::min(
        limits.acceleration_mm_s2, axis_limits.max_acceleration_mm_s2[axis] / moved);
  }
  return limits;
}

}  // namespace

motion::Limits GlassLimitsOf(const FrozenJob& job) {
  const motion::Limits axis_limits = CappedAxisLimitsOf(job);
  const Mat3 axes_per_mm = AxesPerMm(job, axis_limits);
  motion::Limits limits;
  for (int along = 0; along < 3; ++along) {
    const FocusLimits focus = FocusLimitsFor(axes_per_mm.col(along), axis_limits);
    limits.max_speed_mm_s[along] = focus.speed_mm_s;
    limits.max_acceleration_mm_s2[along] = focus.acceleration_mm_s2;
  }
  // A step in depth is a shorter one of the focus in air.
  const double ratio = job.optics().stage_per_glass_ratio();
  limits.max_speed_mm_s.z() /= ratio;
  limits.max_acceleration_mm_s2.z() /= ratio;
  return limits;
}

FocusLimits GlassLimitsAlong(const FrozenJob& job, double turn_rad) {
  const motion::Limits axis_limits = CappedAxisLimitsOf(job);
  const Vec3 direction(std::cos(turn_rad), std::sin(turn_rad), 0);
  return FocusLimitsFor(AxesPerMm(job, axis_limits) * direction, axis_limits);
}

double AxisToleranceOf(const FrozenJob& job, double tolerance_mm) {
  // In the glass a move in depth is longer than in air.
  return tolerance_mm * std::min(1.0, job.optics().stage_per_glass_ratio()) /
         ScaleBoundsOf(job).any_mm;
}

double AxisDepthOf(const FrozenJob& job, double tolerance_mm) {
  return tolerance_mm * std::min(1.0, job.optics().stage_per_glass_ratio()) /
         ScaleBoundsOf(job).axis_mm.z();
}

}  // namespace intaglio
