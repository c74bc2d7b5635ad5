// What a job sets of programs of motion, of layers, of the published order, and what the
// arrangement of pieces and the lens allow.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/options.h"
#include "services/job/fields/field_path.h"
#include "services/job/fields/shapes.h"
#include "services/job/methods/method_table.h"
#include "services/job/quality/focus_spread.h"
#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr double kProgramRatio = 0.65;

std::vector<Finding> Check(const JobSpec& job,
                           const MachineSpec& machine = GoodMachine()) {
  return CheckAll(job, machine, kProgramRatio);
}

FrozenJob FrozenOf(const JobSpec& job) {
  FrozenJob frozen;
  *frozen.mutable_machine() = GoodMachine();
  *frozen.mutable_job() = WithDefaults(job, GoodMachine());
  frozen.mutable_optics()->set_stage_per_glass_ratio(kProgramRatio);
  frozen.mutable_optics()->set_cone_tangent(0.13);
  return frozen;
}

TEST(ProgramOfJob, HeightMassFrictionAndWeightsReachThePlanner) {
  JobSpec job = GoodJob();
  job.mutable_motion()->set_profile(MOTION_PROFILE_PARABOLA);
  EXPECT_FALSE(MotionOptionsOf(FrozenOf(job)).program.parabola_height_mm);
  ASSERT_TRUE(SetField(job, "motion.parabola_height_mm", "0.25"));
  EXPECT_THAT(Check(job), IsEmpty());
  EXPECT_EQ(MotionOptionsOf(FrozenOf(job)).program.parabola_height_mm, 0.25);

  job = GoodJob();
  job.mutable_motion()->set_profile(MOTION_PROFILE_LQ);
  EXPECT_FALSE(MotionOptionsOf(FrozenOf(job)).program.lq);
  ASSERT_TRUE(SetField(job, "motion.lq.moving_mass_kg", "4"));
  ASSERT_TRUE(SetField(job, "motion.lq.friction_n_s_m", "30"));
  ASSERT_TRUE(SetField(job, "motion.lq.speed_weight", "0.002"));
  EXPECT_THAT(Check(job), IsEmpty());
  const auto lq = MotionOptionsOf(FrozenOf(job)).program.lq;
  ASSERT_TRUE(lq);
  EXPECT_EQ(lq->moving_mass_kg, 4);
  EXPECT_EQ(lq->friction_n_s_m, 30);
  EXPECT_EQ(lq->speed_weight, 0.002);
  EXPECT_EQ(lq->force_weight, 1);
}

TEST(ProgramOfJob, FieldsOfAnotherProfileAreRefused) {
  JobSpec job = GoodJob();
  job.mutable_motion()->set_parabola_height_mm(1);
  job.mutable_motion()->mutable_lq();
  EXPECT_THAT(Check(job), ElementsAre(IsFinding("motion.parabola_height_mm", "PARABOLA"),
                                      IsFinding("motion.lq", "MOTION_PROFILE_LQ")));
}

TEST(PublishedOrder, ItsAngleIsTheTangentOfBothWeights) {
  JobSpec job = GoodJob();
  PublishedKdzOrder& order = *job.mutable_ordering()->mutable_published_kdz();
  order.set_angle_deg(30);
  EXPECT_THAT(Check(job), IsEmpty());
  const auto ratios = OrderOptionsOf(FrozenOf(job)).published_kdz;
  EXPECT_DOUBLE_EQ(ratios.up_ratio, std::tan(std::numbers::pi / 6));
  EXPECT_EQ(ratios.down_ratio, ratios.up_ratio);
  order.set_up_ratio(1);
  EXPECT_THAT(Check(job), ElementsAre(IsFinding("ordering.published_kdz.angle_deg",
                                                "30 excludes up_ratio")));
  order.clear_up_ratio();
  order.set_angle_deg(90);
  EXPECT_THAT(Check(job), ElementsAre(IsFinding("ordering.published_kdz.angle_deg",
                                                "90 is outside 0..89")));
}

/// A job of one drawing or image, flat or upright, in layers 0.4 mm apart.
JobSpec LayeredJob(const std::string& file, UpAxis up, int layer_count) {
  JobSpec job = GoodJob();
  Model& model = *job.mutable_models(0);
  const std::string there = model.file();
  model.Clear();
  model.set_file(file);
  model.mutable_placement()->set_up(up);
  if (file.ends_with(".svg")) {
    model.mutable_curves()->set_layer_count(static_cast<std::uint32_t>(layer_count));
    model.mutable_curves()->set_layer_distance_mm(0.4);
  } else {
    model.mutable_halftone()->set_layer_count(static_cast<std::uint32_t>(layer_count));
    model.mutable_halftone()->set_layer_distance_mm(0.4);
  }
  job.mutable_ordering()->mutable_layers()->set_layer_thickness_mm(0.3);
  return job;
}

std::vector<Finding> CheckLayersOf(const JobSpec& job) {
  return CheckJobOnMachine(job, GoodMachine(), kProgramRatio);
}

TEST(SortByLayers, IsNotThinnerThanTheLayersOfImagesAndCurves) {
  for (const char* file : {"plan.svg", "photo.png"}) {
    EXPECT_THAT(CheckLayersOf(LayeredJob(file, UP_AXIS_Z, 3)),
                ElementsAre(IsFinding("ordering.layers.layer_thickness_mm",
                                      "0.3 is less than the layer distance of the ")))
        << file;
    // One layer has no distance; upright, the layers are behind one another.
    EXPECT_THAT(CheckLayersOf(LayeredJob(file, UP_AXIS_Z, 1)), IsEmpty()) << file;
    EXPECT_THAT(CheckLayersOf(LayeredJob(file, UP_AXIS_Y, 3)), IsEmpty()) << file;
  }
}

TEST(SortByLayers, RegardsTheAxisOfTheLayersOfCurves) {
  JobSpec job = LayeredJob("plan.svg", UP_AXIS_Y, 2);
  job.mutable_models(0)->mutable_curves()->set_layer_axis(AXIS_Z);
  EXPECT_EQ(CheckLayersOf(job).size(), 1U);
  // At 60 degrees from z the next layer is half of its distance higher: 0.2.
  job.mutable_models(0)->mutable_curves()->mutable_layer_rotate_deg()->set_x(60);
  EXPECT_THAT(CheckLayersOf(job), IsEmpty());
}

TEST(LayersOfCurves, FollowTheirAxisItsAnglesAndItsSystem) {
  JobSpec job = LayeredJob("plan.svg", UP_AXIS_Z, 2);
  Model& model = *job.mutable_models(0);
  model.mutable_placement()->mutable_rotate_deg()->set_z(90);
  CurvesMethod& curves = *model.mutable_curves();
  const auto direction = [&] {
    const JobSpec whole = WithDefaults(job, GoodMachine());
    const Model& placed = whole.models(0);
    const Mat3 rotation =
        mesh::RotationOf(PlacementOf(placed.placement(), whole.block()).rotation_rad);
    return MethodOf(placed)->layer_axis(placed, rotation).value_or(Vec3::Zero());
  };
  EXPECT_EQ(direction(), Vec3(Vec3::Zero())) << "none: the normal of the sheet";
  curves.set_layer_axis(AXIS_X);
  EXPECT_TRUE(direction().isApprox(Vec3(1, 0, 0), 1e-12));
  curves.set_layer_system(COORDINATE_SYSTEM_OBJECT);
  EXPECT_TRUE(direction().isApprox(Vec3(0, 1, 0), 1e-12));
  curves.mutable_layer_rotate_deg()->set_y(-90);  // of x: up
  EXPECT_TRUE(direction().isApprox(Vec3(0, 0, 1), 1e-12));
}

TEST(Arrangement, PiecesOfSeveralChannelsAreAtMostAsLargeAsTheProfileAllows) {
  MachineSpec machine = GoodMachine();
  Vector3& max_mm = *machine.mutable_max_divided_block_mm();
  max_mm.set_x(100), max_mm.set_y(100), max_mm.set_z(100);
  JobSpec job = GoodJob();
  job.mutable_block()->mutable_size_mm()->set_x(120);
  EXPECT_THAT(Check(job, machine), IsEmpty());
  job.mutable_laser()->add_channels(1);
  job.mutable_laser()->add_channels(3);
  EXPECT_THAT(Check(job, machine),
              ElementsAre(IsFinding("block.size_mm.x",
                                    "120 is above the 100 mm of els-03 for blocks of "
                                    "several channels")));
  job.mutable_block()->mutable_size_mm()->set_x(100);
  EXPECT_THAT(Check(job, machine), IsEmpty());
}

TEST(Arrangement, ABlockFitsUnderItsLens) {
  MachineSpec machine = GoodMachine();
  machine.mutable_lenses(0)->set_max_block_height_mm(20);
  JobSpec job = GoodJob();
  const double height_mm = job.block().size_mm().z();
  ASSERT_GT(height_mm, 20);
  EXPECT_THAT(
      Check(job, machine),
      ElementsAre(IsFinding("block.size_mm.z", "is above the 20 mm of a block under")));
  machine.mutable_lenses(0)->set_max_block_height_mm(height_mm);
  EXPECT_THAT(Check(job, machine), IsEmpty());
}

TEST(FocusSpread, ANoteNamesLensDepthAndRemedyWhereItPassesACrack) {
  FrozenJob job = FrozenOf(GoodJob());
  const double height_mm = job.job().block().size_mm().z();
  EXPECT_THAT(FocusSpreadOf(job, {Vec3(5, 5, 5)}), IsEmpty()) << "no index";
  job.mutable_optics()->set_refractive_index(1.52);
  job.mutable_optics()->set_numerical_aperture(0.2);
  // The spread is 1.161 % of the depth: a crack of 0.135 mm is passed at 11.6 mm.
  EXPECT_THAT(FocusSpreadOf(job, {Vec3(5, 5, height_mm - 11)}), IsEmpty());
  EXPECT_THAT(FocusSpreadOf(job, {}), IsEmpty());
  const Warnings deep =
      FocusSpreadOf(job, {Vec3(5, 5, height_mm - 2), Vec3(5, 5, height_mm - 20)});
  ASSERT_EQ(deep.size(), 1U);
  EXPECT_EQ(deep[0].code, WarningCode::kFocusSpread);
  EXPECT_EQ(deep[0].weight, WarningWeight::kNote);
  EXPECT_THAT(deep[0].text,
              AllOf(HasSubstr("lens f43 is spread over 0.23 mm"),
                    HasSubstr("20.0 mm below the top"), HasSubstr("down to 11.6 mm")));
}

}  // namespace
}  // namespace intaglio
