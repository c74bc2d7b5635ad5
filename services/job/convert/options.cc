#include "services/job/convert/options.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/motion/profiles.h"
#include "engrave/optics/focus.h"
#include "engrave/sort/kdz.h"
#include "services/job/beams/energy_by_place.h"
#include "services/job/convert/rows.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/machine_drives.h"
#include "services/job/machine/position_tolerance.h"

namespace intaglio {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

// What a plan keeps of it however coarse the steps are: deep in a glass of high index
// half a step may be more than the profile's check knows.
constexpr double kMinPlannedRatio = 0.1;

}  // namespace

std::string ProfileName(MotionProfile profile) {
  std::string name = MotionProfile_Name(profile);
  name.erase(0, std::string_view("MOTION_PROFILE_").size());
  for (char& c : name) {
    c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

namespace {

/// The beams of a scan head come from the pupil of the lens. Frame glass.
std::optional<sort::BeamLean> LeanOf(const FrozenJob& job) {
  if (!job.machine().has_head_over_block()) return std::nullopt;
  const optics::MachineFromGlass frame = MachineFromGlassOf(job);
  sort::BeamLean lean;
  lean.pupil_mm = HeadOptionsOf(job.machine().head_over_block()).lens.pupil_mm;
  lean.axis_mm = -frame.block_origin_mm.head<2>();
  lean.top_mm = frame.block_size_mm.z();
  lean.refractive_index =
      std::max(1.0, optics::RefractiveIndexOf(frame.stage_per_glass_ratio,
                                              job.job().lens().numerical_aperture()));
  const Vec2 size_mm = frame.block_size_mm.head<2>();
  lean.widest_mm =
      lean.axis_mm.cwiseAbs().cwiseMax((size_mm - lean.axis_mm).cwiseAbs()).norm();
  return lean;
}

}  // namespace

sort::BeamCone PointConeOf(const FrozenJob& job) {
  sort::BeamCone cone = job.optics().cone_tangent();
  cone.lean = LeanOf(job);
  return cone;
}

sort::BeamCone PointConeInMachine(const FrozenJob& job) {
  const optics::MachineFromGlass frame = MachineFromGlassOf(job);
  sort::BeamCone cone = PointConeOf(job);
  cone.tangent /= frame.stage_per_glass_ratio;
  if (cone.lean) {
    cone.lean->axis_mm += frame.block_origin_mm.head<2>();
    cone.lean->top_mm = frame.top_z_mm();
    cone.lean->depth_ratio = 1 / frame.stage_per_glass_ratio;
  }
  return cone;
}

sort::BeamCone BeamConeOf(const FrozenJob& job) {
  sort::BeamCone cone = PointConeOf(job);
  const MachineLens* lens = FindLens(job.machine(), job.job().lens().focal_length_mm());
  if (lens == nullptr || lens->crack_length_mm() <= 0) return cone;
  cone.crack_radius_mm = 0.5 * lens->crack_diameter_mm();
  cone.crack_length_mm = lens->crack_length_mm();
  return cone;
}

namespace {

/// Trochimczuk 2008 ch. 6.3 gives times by the sorting angle and no formula of K: the
/// tangent reproduces them within 6.5 % (published_angles_test.cc).
sort::PublishedKdzOptions RatiosOf(const PublishedKdzOrder& order) {
  if (!order.has_angle_deg()) return {order.up_ratio(), order.down_ratio()};
  const double k = std::tan(order.angle_deg() * kRadPerDeg);
  return {k, k};
}

/// Sets what a head that jumps and dwells needs.
void SetJumps(const FrozenJob& job, sort::OrderOptions& options) {
  const HeadOverBlockKinematics& head = job.machine().head_over_block();
  if (!head.has_jump_and_dwell()) return;
  const auto kinematics = KinematicsOptionsOf(job.machine());
  const double up =
      std::get<machine::ScanHeadOptions>(kinematics).z.per_unit_mm() > 0 ? 1 : -1;
  options.jump_layers.head_from_glass = [frame = AxesFromGlassOf(job),
                                         up](const Vec3& glass_mm) {
    Vec3 at = frame.ToAxes(glass_mm, Vec3::Zero()).value_or(glass_mm);
    at.z() *= up;
    return at;
  };
  options.jump_layers.jump_mm_s = head.jump_and_dwell().jump_mm_s();
}

void SetMethod(const FrozenJob& job, sort::OrderOptions& options) {
  const Ordering& ordering = job.job().ordering();
  switch (ordering.method_case()) {
    case Ordering::kKdz:
      options.method = sort::Method::kKdz;
      options.kdz.up_ratio = ordering.kdz().has_up_ratio()
                                 ? ordering.kdz().up_ratio()
                                 : sort::DefaultUpRatio(options.cone);
      break;
    case Ordering::kLayers:
      options.method = sort::Method::kLayers;
      options.layers.layer_thickness_mm = ordering.layers().layer_thickness_mm();
      break;
    case Ordering::kSmooth:
      options.method = sort::Method::kSmooth;
      break;
    case Ordering::kAnneal:
      options.method = sort::Method::kAnneal;
      if (ordering.anneal().has_tries_per_point())
        options.anneal.tries_per_point = ordering.anneal().tries_per_point();
      if (ordering.anneal().has_pieces())
        options.anneal.pieces = ordering.anneal().pieces();
      options.anneal.seed = ordering.anneal().seed();
      break;
    case Ordering::kBoustrophedon:
      options.method = sort::Method::kBoustrophedon;
      options.boustrophedon = RowOptionsOf(job, ordering.boustrophedon());
      break;
    case Ordering::kPublishedKdz:
      options.method = sort::Method::kPublishedKdz;
      options.published_kdz = RatiosOf(ordering.published_kdz());
      break;
    case Ordering::kSweep:
      options.method = sort::Method::kSweep;
      options.sweep.slab_mm = ordering.sweep().slab_mm();
      break;
    case Ordering::kJumpLayers:
      options.method = sort::Method::kJumpLayers;
      break;
    case Ordering::METHOD_NOT_SET:
      Require(false, "the job's defaults are not filled in");
  }
}

}  // namespace

namespace {

/// That of the plan, as a depth of the glass below an upright beam: heights of the lens
/// are counted so (engrave/sort/sweep.cc). Under oblique beams the plan has less, since a
/// move of the lens is a longer one of the focus.
double SweepToleranceMm(const FrozenJob& job) {
  const double depth_mm = 1e-3 * job.job().motion().depth_tolerance_um();
  const auto kinematics = KinematicsOptionsOf(job.machine());
  const auto* head = std::get_if<machine::ScanHeadOptions>(&kinematics);
  if (head == nullptr) return depth_mm;
  return AxisDepthOf(job, depth_mm) * std::abs(head->z.per_unit_mm()) /
         job.optics().stage_per_glass_ratio();
}

}  // namespace

sort::OrderOptions OrderOptionsOf(const FrozenJob& job) {
  sort::OrderOptions options;
  options.cone = BeamConeOf(job);
  options.limits = GlassLimitsOf(job);
  options.keeps_more = motion::KeepsMore(MotionOptionsOf(job));
  options.rate_hz = job.job().laser().rate_hz();
  SetMethod(job, options);
  options.sweep.tolerance_mm = SweepToleranceMm(job);
  if (options.method == sort::Method::kJumpLayers) SetJumps(job, options);
  options.jump_layers.energy_from_glass = EnergyStepsOf(job);
  return options;
}

namespace {

/// What only the profiles parabola and lq regard.
motion::ProgramOptions ProgramOptionsOf(const MotionOptions& asked) {
  motion::ProgramOptions program;
  if (asked.has_parabola_height_mm())
    program.parabola_height_mm = asked.parabola_height_mm();
  if (asked.has_lq()) {
    const LqWeights& lq = asked.lq();
    Require(lq.has_moving_mass_kg(), "the job's defaults are not filled in");
    program.lq = motion::LqPlant{lq.moving_mass_kg(), lq.friction_n_s_m(),
                                 lq.speed_weight(), lq.force_weight()};
  }
  return program;
}

/// How far in the glass a plan may bring the focus beside its point.
double PlannedErrorMm(const FrozenJob& job) {
  const double planned_mm =
      kPlannedErrorRatio * 1e-3 * job.machine().position_tolerance_um();
  return std::max(kMinPlannedRatio * planned_mm, planned_mm - HalfStepInGlassMm(job));
}

/// What only the motion that does not stop regards.
void SetOptionalLimits(const FrozenJob& job, motion::PlanOptions& plan) {
  const motion::Limits own = AxisLimitsOf(job.machine());
  plan.limits.max_jerk_mm_s3 = own.max_jerk_mm_s3;
  plan.limits.max_speed_norm_mm_s = own.max_speed_norm_mm_s;
  plan.limits.max_acceleration_norm_mm_s2 = own.max_acceleration_norm_mm_s2;
  plan.tolerance_mm = AxisToleranceOf(job, 1e-3 * job.job().motion().tolerance_um());
  // Where the place decides and not the tick, nothing is late.
  if (job.machine().pulse_trigger() == PULSE_TRIGGER_AT_PLACE) return;
  plan.sweep_mm = AxisDepthOf(job, 1e-3 * job.job().motion().depth_tolerance_um());
  plan.error_limit = AxisToleranceOf(job, PlannedErrorMm(job));
}

}  // namespace

motion::PlanOptions MotionOptionsOf(const FrozenJob& job) {
  const MotionOptions& asked = job.job().motion();
  Require(asked.has_max_speed_mm_s() && job.job().laser().has_rate_hz(),
          "the job's defaults are not filled in");
  motion::PlanOptions result;
  result.limits = CappedAxisLimitsOf(job);
  result.rate_hz = job.job().laser().rate_hz();
  result.continuous = asked.profile() == MOTION_PROFILE_CONTINUOUS;
  if (!result.continuous) {
    const auto profile = motion::ProfileByName(ProfileName(asked.profile()));
    Require(profile.has_value(), "motion.profile: {} is not a profile",
            static_cast<int>(asked.profile()));
    result.profile = *profile;
  }
  result.program = ProgramOptionsOf(asked);
  result.drives = DrivesOf(job.machine());
  if (result.continuous) SetOptionalLimits(job, result);
  return result;
}

}  // namespace intaglio
