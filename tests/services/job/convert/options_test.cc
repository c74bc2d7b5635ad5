#include "services/job/convert/options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/drive/drive_kinds.h"
#include "engrave/motion/profiles.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_drives.h"
#include "services/job/models/model_sources.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

FrozenJob Frozen(JobSpec job) {
  FrozenJob frozen;
  *frozen.mutable_machine() = GoodMachine();
  *frozen.mutable_job() = WithDefaults(std::move(job), GoodMachine());
  frozen.mutable_optics()->set_stage_per_glass_ratio(0.65);
  frozen.mutable_optics()->set_cone_tangent(0.13);
  return frozen;
}

TEST(Options, PlacementTurnsDegreesIntoRadians) {
  JobSpec job = GoodJob();
  Placement& asked = *job.mutable_models(0)->mutable_placement();
  asked.mutable_rotate_deg()->set_z(-90);
  asked.set_mirror_y(true);
  asked.mutable_move_mm()->set_x(4);
  asked.set_unit_mm(25.4);
  job = WithDefaults(job, GoodMachine());
  const mesh::Placement placement = PlacementOf(job.models(0).placement(), job.block());
  EXPECT_DOUBLE_EQ(placement.rotation_rad.z(), -std::numbers::pi / 2);
  EXPECT_EQ(placement.unit_mm, 25.4);
  EXPECT_TRUE(placement.mirror_y);
  EXPECT_FALSE(placement.mirror_x);
  EXPECT_EQ(placement.move_mm, Vec3(4, 0, 0));
  EXPECT_TRUE(placement.centre_in_block);
  ASSERT_TRUE(std::holds_alternative<mesh::FitHeight>(placement.fit));
  EXPECT_EQ(std::get<mesh::FitHeight>(placement.fit).height_mm, 22);
}

TEST(Options, EveryUpAxisIsThatOfThePlacement) {
  JobSpec job = WithDefaults(GoodJob(), GoodMachine());
  Placement placement = job.models(0).placement();
  const std::map<UpAxis, mesh::UpAxis> expected = {
      {UP_AXIS_DEFAULT, mesh::UpAxis::kZ},
      {UP_AXIS_Z, mesh::UpAxis::kZ},
      {UP_AXIS_Y, mesh::UpAxis::kY},
      {UP_AXIS_X, mesh::UpAxis::kX},
      {UP_AXIS_MINUS_Z, mesh::UpAxis::kMinusZ},
      {UP_AXIS_MINUS_Y, mesh::UpAxis::kMinusY},
      {UP_AXIS_MINUS_X, mesh::UpAxis::kMinusX},
      {UP_AXIS_DECLARED, mesh::UpAxis::kX}};
  ASSERT_EQ(expected.size(), static_cast<std::size_t>(UpAxis_ARRAYSIZE));
  for (const auto& [asked, up] : expected) {
    placement.set_up(asked);
    EXPECT_EQ(PlacementOf(placement, job.block(), mesh::UpAxis::kX).up, up)
        << UpAxis_Name(asked);
  }
  placement.set_up(UP_AXIS_DECLARED);
  EXPECT_EQ(PlacementOf(placement, job.block()).up, mesh::UpAxis::kZ)
      << "of a file that declares none";
}

// Upright by what the format defines. A model that is given a rotation is rotated as it
// lies in its file: so are those of job files and stored jobs that were written before.
TEST(Options, UpFollowsFromTheKindAndTheFormat) {
  const auto up_of = [](const std::string& file, bool rotated = false) {
    JobSpec job = GoodJob();
    Model& model = *job.mutable_models(0);
    model.Clear();
    if (file.empty()) {
      model.mutable_text()->set_text("Anna");
    } else {
      model.set_file(file);
    }
    if (rotated) model.mutable_placement()->mutable_rotate_deg()->set_z(30);
    return WithDefaults(WithDefaults(job, GoodMachine()), GoodMachine())
        .models(0)
        .placement()
        .up();
  };
  for (const char* upright : {"", "a.glb", "a.GLTF", "a.svg", "a.dxf", "a.plt", "a.nci",
                              "a.png", "a.jpg", "a.bmp"}) {
    EXPECT_EQ(up_of(upright), UP_AXIS_Y) << upright;
    EXPECT_EQ(up_of(upright, true), UP_AXIS_Z) << upright << ", rotated";
  }
  EXPECT_EQ(up_of("a.dae"), UP_AXIS_DECLARED);
  for (const char* as_it_is : {"a.stl", "a.3mf", "a.3ds", "a.xyz", "a.cft", "a.scl"}) {
    EXPECT_EQ(up_of(as_it_is), UP_AXIS_Z) << as_it_is;
  }
  for (const char* asked_about : {"a.obj", "a.PLY"}) {
    EXPECT_EQ(up_of(asked_about), UP_AXIS_DECLARED) << asked_about;
    EXPECT_EQ(up_of(asked_about, true), UP_AXIS_Z) << asked_about << ", rotated";
  }
}

TEST(Options, FitBlockLeavesTheMargin) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->mutable_placement()->set_fit_block(true);
  job = WithDefaults(job, GoodMachine());
  const mesh::Placement placement = PlacementOf(job.models(0).placement(), job.block());
  ASSERT_TRUE(std::holds_alternative<mesh::FitBox>(placement.fit));
  EXPECT_EQ(std::get<mesh::FitBox>(placement.fit).size_mm, Vec3(44, 44, 24));
  EXPECT_EQ(PermittedBoxOf(job.block()).min_mm, Vec3(3, 3, 3));
  EXPECT_EQ(PermittedBoxOf(job.block()).max_mm, Vec3(47, 47, 27));
}

TEST(Options, MotionIsCappedAxisByAxis) {
  JobSpec job = GoodJob();
  job.mutable_motion()->set_max_speed_mm_s(50);
  job.mutable_motion()->set_profile(MOTION_PROFILE_CUBIC);
  FrozenJob frozen = Frozen(job);
  frozen.mutable_machine()->mutable_z()->set_max_speed_mm_s(20);
  const motion::PlanOptions motion = MotionOptionsOf(frozen);
  EXPECT_EQ(motion.limits.max_speed_mm_s, Vec3(50, 50, 20));
  EXPECT_EQ(motion.limits.max_acceleration_mm_s2, Vec3(7000, 7000, 7000));
  EXPECT_EQ(motion.rate_hz, 100);
  EXPECT_EQ(motion.profile, motion::Profile::kCubic);
}

TEST(Options, EveryProfileOfAJobIsOneOfThePlanner) {
  std::size_t stopping = 0;
  for (int number = MotionProfile_MIN; number <= MotionProfile_MAX; ++number) {
    const auto profile = static_cast<MotionProfile>(number);
    JobSpec job = GoodJob();
    job.mutable_motion()->set_profile(profile);
    const motion::PlanOptions plan = MotionOptionsOf(Frozen(job));
    EXPECT_EQ(plan.continuous, profile == MOTION_PROFILE_CONTINUOUS);
    if (plan.continuous) continue;
    ++stopping;
    EXPECT_EQ(motion::ProfileByName(ProfileName(profile)), plan.profile);
  }
  EXPECT_EQ(stopping, motion::Profiles().size());
  EXPECT_EQ(ProfileName(MOTION_PROFILE_TIME_OPTIMAL), "time-optimal");
  EXPECT_EQ(ProfileName(static_cast<MotionProfile>(99)), "");
}

TEST(Options, TheDriveIsTheOneThatTheProfileNames) {
  FrozenJob frozen = Frozen(GoodJob());
  frozen.mutable_machine()->set_stage_lag_s(0.003);
  const drive::Cubic ramp = {0, 80, 0, 0};
  const auto first = MotionOptionsOf(frozen).drives[0];
  EXPECT_EQ(first->name(), "first_order");
  EXPECT_EQ(first->CommandFor(ramp).position_u, 80 * 0.003);
  auto& asked = *frozen.mutable_machine()->mutable_second_order();
  asked.set_natural_frequency_hz(50);
  asked.set_damping_ratio(0.5);
  const auto second = MotionOptionsOf(frozen).drives[2];
  EXPECT_EQ(second->name(), "second_order");
  EXPECT_NEAR(second->CommandFor(ramp).position_u,
              80 * 2 * 0.5 / (2 * std::numbers::pi * 50), 1e-12);
}

// Each row of the registry is a field of the profile that carries its name, and the
// values arrive in their order: a value of its own for each parameter.
TEST(Options, EachKindOfDriveIsMadeFromItsMessage) {
  const auto* oneof = MachineSpec::descriptor()->FindOneofByName("drive");
  ASSERT_EQ(oneof->field_count(), static_cast<int>(drive::DriveKinds().size()));
  for (int i = 0; i < oneof->field_count(); ++i) {
    const auto* field = oneof->field(i);
    if (field->message_type() == nullptr) continue;
    MachineSpec machine;
    auto& message = *MachineSpec::GetReflection()->MutableMessage(&machine, field);
    std::vector<double> values;
    for (int k = 0; k < message.GetDescriptor()->field_count(); ++k) {
      const auto* parameter = message.GetDescriptor()->field(k);
      const NumberRange range = RangeOf(*parameter);
      values.push_back(0.999 * range.min + 0.001 * range.max);
      message.GetReflection()->SetDouble(&message, parameter, values.back());
    }
    const auto expected = drive::MakeDrive(field->name(), values);
    ASSERT_TRUE(expected.has_value()) << expected.error().message;
    const auto made = DrivesOf(machine)[1];
    EXPECT_EQ(made->name(), field->name());
    EXPECT_EQ(made->transfer().numerator, (*expected)->transfer().numerator);
    EXPECT_EQ(made->transfer().denominator, (*expected)->transfer().denominator);
  }
}

TEST(Options, AnAxisMayHaveADriveOfItsOwn) {
  FrozenJob frozen = Frozen(GoodJob());
  frozen.mutable_machine()->set_stage_lag_s(0.003);
  AxisDrive& own = *frozen.mutable_machine()->add_axis_drives();
  own.set_axis("y");
  own.mutable_second_order()->set_natural_frequency_hz(50);
  own.mutable_second_order()->set_damping_ratio(0.5);
  const drive::AxisDrives drives = MotionOptionsOf(frozen).drives;
  EXPECT_EQ(drives[0]->name(), "first_order");
  EXPECT_EQ(drives[1]->name(), "second_order");
  EXPECT_EQ(drives[2]->name(), "first_order");
}

// The planned error leaves a fifth of the tolerance, and half a step of the axes; what
// fires at a place is not late.
TEST(Options, TheErrorLimitIsOfTheToleranceInTheGlass) {
  FrozenJob frozen = Frozen(GoodJob());
  frozen.mutable_machine()->set_position_tolerance_um(30);
  frozen.mutable_optics()->set_stage_per_glass_ratio(1);
  EXPECT_NEAR(MotionOptionsOf(frozen).error_limit, 0.024, 1e-12);
  frozen.mutable_machine()->mutable_x()->set_steps_per_mm(100);
  frozen.mutable_machine()->mutable_y()->set_steps_per_mm(125);
  EXPECT_NEAR(MotionOptionsOf(frozen).error_limit, 0.024 - std::hypot(0.005, 0.004),
              1e-12);
  frozen.mutable_machine()->mutable_z()->set_steps_per_mm(1);
  EXPECT_NEAR(MotionOptionsOf(frozen).error_limit, 0.0024, 1e-12) << "and never 0";
  frozen.mutable_machine()->set_pulse_trigger(PULSE_TRIGGER_AT_PLACE);
  EXPECT_EQ(MotionOptionsOf(frozen).error_limit, 0);
}

// A profile that is good makes a drive, and one that makes none is no good profile.
TEST(Options, TheRangesOfAProfileAreThoseOfTheDrives) {
  const google::protobuf::Descriptor& profile = *MachineSpec::descriptor();
  for (const drive::DriveKind& kind : drive::DriveKinds()) {
    for (const drive::DriveParameter& parameter : kind.parameters) {
      const auto* drive = profile.FindFieldByName(std::string(kind.name));
      const auto* field =
          drive == nullptr
              ? profile.FindFieldByName("stage_lag_s")
              : drive->message_type()->FindFieldByName(std::string(parameter.name));
      ASSERT_NE(field, nullptr) << parameter.name;
      const NumberRange range = RangeOf(*field);
      EXPECT_EQ(range.min, parameter.min) << field->full_name();
      EXPECT_EQ(range.max, parameter.max) << field->full_name();
    }
  }
}

TEST(Options, ThePlannersKnowWhereTheTravelEnds) {
  FrozenJob frozen = Frozen(GoodJob());
  frozen.mutable_machine()->mutable_y()->set_travel_min_mm(-7);
  frozen.mutable_machine()->mutable_z()->set_travel_max_mm(99);
  const Box3 travel_mm = MotionOptionsOf(frozen).limits.travel_mm;
  EXPECT_EQ(travel_mm.min_mm.y(), -7);
  EXPECT_EQ(travel_mm.max_mm.z(), 99);
}

TEST(Options, OptionalLimitsAreForTheMotionThatDoesNotStop) {
  JobSpec job = GoodJob();
  job.mutable_motion()->set_tolerance_um(15);
  FrozenJob frozen = Frozen(job);
  const motion::Limits none = MotionOptionsOf(frozen).limits;
  EXPECT_EQ(none.max_jerk_mm_s3, Vec3::Constant(motion::kUnlimited));
  EXPECT_EQ(none.max_speed_norm_mm_s, motion::kUnlimited);
  MachineSpec& machine = *frozen.mutable_machine();
  machine.mutable_y()->set_max_jerk_mm_s3(2e6);
  machine.set_max_speed_norm_mm_s(90);
  machine.set_max_acceleration_norm_mm_s2(8000);
  frozen.mutable_optics()->set_stage_per_glass_ratio(0.6);
  const motion::PlanOptions plan = MotionOptionsOf(frozen);
  EXPECT_EQ(plan.limits.max_jerk_mm_s3,
            Vec3(motion::kUnlimited, 2e6, motion::kUnlimited));
  EXPECT_EQ(plan.limits.max_speed_norm_mm_s, 90);
  EXPECT_EQ(plan.limits.max_acceleration_norm_mm_s2, 8000);
  EXPECT_NEAR(plan.tolerance_mm, 0.009, 1e-15) << "15 um in the glass, along the beam";
  frozen.mutable_job()->mutable_motion()->set_profile(MOTION_PROFILE_MIX);
  const motion::PlanOptions stopping = MotionOptionsOf(frozen);
  EXPECT_EQ(stopping.limits.max_jerk_mm_s3.y(), motion::kUnlimited);
  EXPECT_EQ(stopping.tolerance_mm, 0);
}

TEST(Options, ThinningBoundsAndClip) {
  JobSpec job = GoodJob();
  job.mutable_block()->set_clip(true);
  job.mutable_discretization()->set_height_ratio(1.5);
  const auto options = CloudOptionsOf(WithDefaults(job, GoodMachine()));
  EXPECT_EQ(options.thinning.min_spacing_mm, 0.3);
  EXPECT_EQ(options.thinning.height_ratio, 1.5);
  EXPECT_TRUE(options.clip);
  EXPECT_EQ(options.permitted_mm.max_mm, Vec3(47, 47, 27));
}

TEST(Options, OrderFollowsTheCone) {
  FrozenJob job = Frozen(GoodJob());
  job.mutable_optics()->set_cone_tangent(0.9);
  EXPECT_EQ(OrderOptionsOf(job).method, sort::Method::kAnneal);
  EXPECT_EQ(OrderOptionsOf(job).anneal.tries_per_point, std::nullopt);
  EXPECT_EQ(OrderOptionsOf(job).anneal.pieces, 1);
  EXPECT_EQ(OrderOptionsOf(job).cone.tangent, 0.9);
  const MachineLens& lens = job.machine().lenses(0);
  EXPECT_EQ(OrderOptionsOf(job).cone.crack_radius_mm, lens.crack_diameter_mm() / 2);
  EXPECT_EQ(OrderOptionsOf(job).cone.crack_length_mm, lens.crack_length_mm());

  Ordering& ordering = *job.mutable_job()->mutable_ordering();
  ordering.mutable_kdz();
  EXPECT_EQ(OrderOptionsOf(job).method, sort::Method::kKdz);
  EXPECT_EQ(OrderOptionsOf(job).kdz.up_ratio, OrderOptionsOf(job).cone.SteepestTangent());
  ordering.mutable_kdz()->set_up_ratio(0.7);
  EXPECT_EQ(OrderOptionsOf(job).kdz.up_ratio, 0.7);
  ordering.mutable_layers()->set_layer_thickness_mm(0.4);
  EXPECT_EQ(OrderOptionsOf(job).method, sort::Method::kLayers);
  EXPECT_EQ(OrderOptionsOf(job).layers.layer_thickness_mm, 0.4);
  ordering.mutable_boustrophedon()->set_row_width_mm(0.3);
  EXPECT_EQ(OrderOptionsOf(job).method, sort::Method::kBoustrophedon);
  EXPECT_EQ(OrderOptionsOf(job).boustrophedon.row_width_mm, 0.3);
  ordering.mutable_published_kdz()->set_down_ratio(0.2);
  EXPECT_EQ(OrderOptionsOf(job).method, sort::Method::kPublishedKdz);
  EXPECT_EQ(OrderOptionsOf(job).published_kdz.down_ratio, 0.2);
  ordering.mutable_smooth();
  EXPECT_EQ(OrderOptionsOf(job).method, sort::Method::kSmooth);
  ordering.clear_method();
  EXPECT_THROW(OrderOptionsOf(job), PreconditionError);
}

TEST(Options, OrderFeelsTheStageInTheGlass) {
  // A stage that goes 0.65 mm for a millimetre of depth is that much faster in it.
  const sort::OrderOptions options = OrderOptionsOf(Frozen(GoodJob()));
  EXPECT_EQ(options.rate_hz, 100);
  EXPECT_EQ(options.limits.max_speed_mm_s.x(), 80);
  EXPECT_EQ(options.limits.max_speed_mm_s.z(), 80 / 0.65);
  EXPECT_EQ(options.limits.max_acceleration_mm_s2.z(), 7000 / 0.65);
}

TEST(Options, LensIsTheJobs) {
  const JobSpec job = WithDefaults(GoodJob(), GoodMachine());
  EXPECT_EQ(LensOf(job).focal_length_mm, 43);
  EXPECT_EQ(LensOf(job).numerical_aperture, 5.0 / 86) << "by the beam's diameter";
}

TEST(Options, FocusDepthGoesIntoTheMachineFrame) {
  const auto frame = MachineFromGlassOf(Frozen(GoodJob()));
  EXPECT_EQ(frame.ToMachine(Vec3(1, 2, 30)), Vec3(1, 2, 30));
  EXPECT_NEAR(frame.ToMachine(Vec3(1, 2, 20)).z(), 30 - 6.5, 1e-12);  // rounding
}

TEST(Options, AJobWithoutItsDefaultsIsRefused) {
  FrozenJob frozen;
  *frozen.mutable_job() = GoodJob();
  EXPECT_THROW(MotionOptionsOf(frozen), PreconditionError);
  EXPECT_THROW(MachineFromGlassOf(frozen), PreconditionError);
}

}  // namespace
}  // namespace intaglio
