// The preview of a job against the code that makes and plans it.

#include "services/client/preview/preview.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <set>

#include "engrave/machine/axes_from_glass.h"
#include "materials_db/material_store.h"
#include "services/client/preview/depth_hint.h"
#include "services/client/preview/preview_picture.h"
#include "services/client/preview/preview_text.h"
#include "services/client/preview/preview_time.h"
#include "services/job/convert/options.h"
#include "services/job/files/freeze.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/plan/plan_summary.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

FrozenJob FrozenOf(const JobSpec& job) {
  auto store = materials_db::MaterialStore::Open(test::FreshFolder() / "materials.db");
  const auto frozen =
      FreezeJob(job, GoodMachine(), store->Find("N-BK7").value(), {"", 0, "", "1.2.3"});
  EXPECT_TRUE(frozen) << frozen.error().message;
  return frozen.value_or(FrozenJob());
}

Result<Preview> PreviewOf(const JobSpec& job, PreviewOptions options = {}) {
  return MakePreview(FrozenOf(job), options, {});
}

std::string ContentOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A spacing of 0.0000 mm would be false: there is none.
TEST(Preview, ThePictureOfOnePointHasNoSpacing) {
  JobPreview one, near;
  for (JobPreview* figures : {&one, &near}) {
    figures->set_point_count(1);
    for (const auto set : {&Vector3::set_x, &Vector3::set_y, &Vector3::set_z})
      (figures->mutable_block_size_mm()->*set)(20);
  }
  near.set_measured_spacing_mm(1e-9);  // is written 0.0000 mm
  EXPECT_NE(DrawPreview(one, {Vec3(7, 8, 9)}), DrawPreview(near, {Vec3(7, 8, 9)}));
}

TEST(Preview, HasSizePointsTimeAndPictureOfTheJob) {
  const auto preview = PreviewOf(GoodJob());  // a knot of 22 mm, 0.3 mm, block 50 50 30
  ASSERT_TRUE(preview) << preview.error().message;
  const JobPreview& figures = preview->figures;
  EXPECT_EQ(figures.name(), "trefoil knot");
  EXPECT_EQ(figures.software_version(), "1.2.3");
  EXPECT_EQ(figures.verdict(), kReady);
  EXPECT_NEAR(figures.size_mm().z(), 22, 0.1);
  EXPECT_NEAR(figures.low_mm().z(), 4, 0.1) << "centred in 30 mm";
  EXPECT_GE(figures.measured_spacing_mm(), 0.3 - 1e-9);
  EXPECT_GT(figures.point_count(), 1000u);
  EXPECT_EQ(figures.time().planned_count(), figures.point_count());
  EXPECT_EQ(figures.time().order(), "anneal");
  EXPECT_EQ(figures.time().warm_up_s(), 30);
  EXPECT_EQ(figures.time().machining_time_s(),
            static_cast<double>(figures.time().ticks()) / 100);
  EXPECT_GE(figures.time().ticks(), figures.point_count()) << "a tick makes one point";
  EXPECT_EQ(figures.breakage().risky_count(), 0u);
  ASSERT_EQ(figures.models_size(), 1);
  EXPECT_EQ(figures.models(0).name(), "sample.obj");
  EXPECT_EQ(figures.models(0).kind(), "a mesh");
  EXPECT_EQ(figures.models(0).point_count(), figures.point_count());
  ASSERT_EQ(preview->pictures.size(), 1u);
  EXPECT_EQ(preview->pictures[0].png[1], 'P');
}

TEST(Preview, ATightSolidMayBreakAndNeedsAConsent) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->mutable_placement()->set_fit_height_mm(6);
  job.mutable_discretization()->mutable_solid();
  job.mutable_discretization()->set_min_spacing_mm(0.09);
  const auto preview = PreviewOf(job);
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_EQ(preview->figures.verdict(), kNeedsConsent);
  EXPECT_GT(preview->figures.breakage().risky_count(), 0u);
  EXPECT_THAT(VerdictText(preview->figures), HasSubstr("--accept breakage"));
  ASSERT_FALSE(preview->figures.warnings().empty());
  EXPECT_EQ(preview->figures.warnings(0).weight(), "consent") << "the heaviest first";
}

TEST(Preview, EachChannelHasItsPicture) {
  JobSpec job = GoodJob();
  *job.add_models() = job.models(0);
  job.mutable_models(0)->add_channels(1);
  job.mutable_models(1)->add_channels(2);
  job.mutable_laser()->add_channels(1);
  job.mutable_laser()->add_channels(2);
  const auto preview = PreviewOf(job);
  ASSERT_TRUE(preview) << preview.error().message;
  ASSERT_EQ(preview->figures.channels_size(), 2);
  EXPECT_EQ(preview->figures.channels(0).point_count() +
                preview->figures.channels(1).point_count(),
            preview->figures.point_count());
  ASSERT_EQ(preview->pictures.size(), 3u);
  EXPECT_EQ(preview->pictures[2].file, "preview-channel-2.png");
}

TEST(Preview, WhatIsRefusedInAJobIsRefusedHere) {
  JobSpec job = GoodJob();
  job.mutable_models(0)->mutable_placement()->clear_fit();
  job.mutable_models(0)->mutable_placement()->set_unit_mm(1000);
  const auto preview = PreviewOf(job);
  ASSERT_FALSE(preview);
  EXPECT_EQ(preview.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(preview.error().message, HasSubstr("--unit"));
}

TEST(Preview, ALensThatWouldEnterTheBlockIsRefused) {
  JobSpec job = GoodJob();
  job.mutable_block()->mutable_size_mm()->set_z(100);
  job.mutable_models(0)->mutable_placement()->mutable_move_mm()->set_z(-20);
  const auto refused = PreviewOf(job);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(refused.error().message, HasSubstr("the lens f43 would be"));
  EXPECT_THAT(refused.error().message, HasSubstr("take the lens f70"));
  job.mutable_models(0)->mutable_placement()->mutable_move_mm()->set_z(20);
  EXPECT_TRUE(PreviewOf(job));
}

TEST(Preview, EndsWhenItIsNotWantedAnyMore) {
  std::set<std::string> stages;
  const FrozenJob job = FrozenOf(GoodJob());
  ASSERT_TRUE(MakePreview(job, {}, [&](const char* stage, auto, auto) {
    stages.insert(stage);
    return true;
  }));
  for (const std::string& last : stages) {
    const auto preview = MakePreview(
        job, {}, [&](const char* stage, auto, auto) { return stage != last; });
    ASSERT_FALSE(preview) << last;
    EXPECT_EQ(preview.error().code, ErrorCode::kCancelled) << last;
  }
}

TEST(Preview, TheFolderHasPageFiguresAndPictures) {
  JobSpec job = GoodJob();
  job.set_name("Anna & <Björn>");
  const auto preview = PreviewOf(job);
  ASSERT_TRUE(preview);
  const fs::path folder = test::FreshFolder() / "a" / "b";
  const Status written = WritePreview(folder, *preview);
  ASSERT_TRUE(written) << written.error().message;
  JobPreview read;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(
                  ContentOf(folder / "preview.json"), &read)
                  .ok());
  EXPECT_EQ(read.SerializeAsString(), preview->figures.SerializeAsString());
  EXPECT_EQ(ContentOf(folder / read.picture()).substr(1, 3), "PNG");
  EXPECT_THAT(ContentOf(folder / "preview.html"), HasSubstr("Anna &amp; &lt;Björn&gt;"));
  const fs::path file = folder / "preview.json" / "inside";
  EXPECT_EQ(WritePreview(file, *preview).error().code, ErrorCode::kIo);
}

// ---- the time ------------------------------------------------------------------------

/// A scatter over the block, from the lowest point up as a cloud is.
PointList Scatter(std::size_t count) {
  PointList points_mm;
  std::uint64_t random = 1;
  const auto next = [&] {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(random >> 11) / 9007199254740992.0;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count);
    points_mm.emplace_back(5 + 40 * next(), 5 + 40 * next(), 4 + 22 * share);
  }
  return points_mm;
}

TEST(PreviewTime, IsThatOfThePlanWhenAllIsPlanned) {
  JobSpec spec = GoodJob();
  spec.mutable_ordering()->mutable_boustrophedon();
  const FrozenJob job = FrozenOf(spec);
  const PointList points_mm = Scatter(2000);
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto time = EstimateTime(job, {points_mm, masks}, 10'000, {}, {});
  ASSERT_TRUE(time) << time.error().message;
  EXPECT_EQ(time->order(), "boustrophedon");

  PlanInput plan;
  plan.options = MotionOptionsOf(job);
  const auto order = sort::MakeChannelOrder(points_mm, masks, OrderOptionsOf(job));
  PointList path_mm;
  for (const std::uint32_t i : *order) path_mm.push_back(points_mm[i]);
  plan.machine_points_mm = *machine::AxesAlong(AxesFromGlassOf(job), path_mm,
                                               AxisLimitsOf(job.machine()).travel_mm);
  const auto summary = Summarize(plan, [](auto, auto) { return true; });
  EXPECT_EQ(time->ticks(), summary->ticks);
}

// A head that jumps and dwells takes the times of its profile, whatever the ticks.
TEST(PreviewTime, OfAHeadThatJumpsIsBySteps) {
  FrozenJob job = FrozenOf(GoodJob());
  MachineSpec& machine = *job.mutable_machine();
  *machine.mutable_head_over_block() = {};
  JumpAndDwell& jumps = *machine.mutable_head_over_block()->mutable_jump_and_dwell();
  jumps.set_z_step_mm(1);
  jumps.set_jump_mm_s(2000);
  jumps.set_jump_delay_s(0.0002);
  jumps.set_dwell_s(0.0005);
  jumps.set_z_settle_s(0.25);
  job.mutable_job()->mutable_ordering()->mutable_jump_layers();
  const PointList points_mm = Scatter(2000);
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto time = EstimateTime(job, {points_mm, masks}, 10, {}, {});
  ASSERT_TRUE(time) << time.error().message;
  const JumpTimePreview& parts = time->jumps();
  EXPECT_EQ(time->planned_count(), 2000u);
  EXPECT_NEAR(parts.dwell_s(), 2000 * 0.0005, 1e-9);
  EXPECT_NEAR(parts.delay_s(), 2000 * 0.0002, 1e-9);
  // 22 mm of glass are 22 / 1.52 steps of 1 mm.
  EXPECT_NEAR(static_cast<double>(parts.z_move_count()), 14, 1);
  EXPECT_GT(parts.z_s(), 0.25 * static_cast<double>(parts.z_move_count()));
  EXPECT_EQ(parts.list_count(), parts.z_move_count() + 1) << "lists have no limit";
  // 0.75 sqrt(n A) a layer, of 15 layers of 40 x 40 mm.
  EXPECT_NEAR(parts.jump_s(), 0.75 * std::sqrt(15.0 * 2000) * 40 / 2000, 0.5);
  EXPECT_NEAR(time->machining_time_s(),
              parts.jump_s() + parts.delay_s() + parts.dwell_s() + parts.z_s(), 1e-9);
}

// Pieces of a scatter take the time of the whole but for their faces, where points have
// fewer neighbours: a tenth of 1000 points of a cube are at each of its faces.
TEST(PreviewTime, OfASampleIsThatOfTheWhole) {
  JobSpec spec = GoodJob();
  spec.mutable_ordering()->mutable_smooth();
  const FrozenJob job = FrozenOf(spec);
  const PointList points_mm = Scatter(20'000);
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto whole = EstimateTime(job, {points_mm, masks}, 20'000, {}, {});
  const auto sample = EstimateTime(job, {points_mm, masks}, 10'000, {}, {});
  ASSERT_TRUE(whole && sample);
  EXPECT_EQ(whole->planned_count(), 20'000u);
  EXPECT_EQ(sample->planned_count(), 10'000u);
  const auto ticks = static_cast<double>(whole->ticks());
  EXPECT_NEAR(static_cast<double>(sample->ticks()), ticks, 0.05 * ticks);
  // The bound is that of all points, however many were planned.
  EXPECT_GE(whole->ticks_bound(), points_mm.size());
  EXPECT_LE(whole->ticks_bound(), whole->ticks());
  EXPECT_EQ(sample->ticks_bound(), whole->ticks_bound());
}

/// A job of a head of two fast mirrors and a slow z at 4 kHz.
FrozenJob SweptJob(double depth_tolerance_um) {
  JobSpec spec = GoodJob();
  spec.mutable_ordering()->mutable_sweep();
  spec.mutable_motion()->set_depth_tolerance_um(depth_tolerance_um);
  FrozenJob job = FrozenOf(spec);
  for (AxisLimits* mirror :
       {job.mutable_machine()->mutable_x(), job.mutable_machine()->mutable_y()}) {
    mirror->set_max_speed_mm_s(8000);
    mirror->set_max_acceleration_mm_s2(5e7);
  }
  job.mutable_machine()->mutable_z()->set_max_speed_mm_s(50);
  job.mutable_machine()->mutable_z()->set_max_acceleration_mm_s2(1000);
  job.mutable_job()->mutable_laser()->set_rate_hz(4000);
  return job;
}

// A slow axis that starts and stops in each piece took 8 % of its ticks.
TEST(PreviewTime, OfASampleOfASweepIsThatOfTheWhole) {
  const FrozenJob job = SweptJob(50);
  const PointList points_mm = Scatter(60'000);
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto whole = EstimateTime(job, {points_mm, masks}, 60'000, {}, {});
  const auto sample = EstimateTime(job, {points_mm, masks}, 3'000, {}, {});
  ASSERT_TRUE(whole && sample) << whole.error().message;
  EXPECT_LT(sample->planned_count(), 20'000u);
  const auto ticks = static_cast<double>(whole->ticks());
  EXPECT_NEAR(static_cast<double>(sample->ticks()), ticks, 0.03 * ticks);
}

TEST(SlowDepthAxis, IsANoteWithWhatAWiderToleranceSaves) {
  const PointList points_mm = Scatter(5'000);
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const CloudToTime cloud{points_mm, masks};
  const auto hint_of = [&](const FrozenJob& job, TimePreview& time) {
    time = EstimateTime(job, cloud, 5'000, {}, {}).value();
    return SlowDepthAxisIn(job, time, cloud, 5'000, {}, {}).value();
  };
  FrozenJob narrow = SweptJob(5);
  for (MachineLens& lens : *narrow.mutable_machine()->mutable_lenses())
    lens.set_crack_length_mm(0.15);
  TimePreview time, wide_time;
  const auto hint = hint_of(narrow, time);
  ASSERT_TRUE(hint) << time.utilisation() << " points a tick";
  EXPECT_EQ(hint->weight, WarningWeight::kNote);
  EXPECT_THAT(hint->text, HasSubstr("--set motion.depth_tolerance_um=50"));
  FrozenJob wide = SweptJob(50);
  *wide.mutable_machine() = narrow.machine();
  EXPECT_FALSE(hint_of(wide, wide_time)) << "it has that tolerance already";
  EXPECT_LT(wide_time.machining_time_s(), 0.9 * time.machining_time_s());
  EXPECT_THAT(hint->text,
              HasSubstr(fmt::format("gives {:.2f}", wide_time.utilisation())));
  narrow.mutable_job()->mutable_ordering()->mutable_sweep()->set_slab_mm(0.4);
  EXPECT_FALSE(hint_of(narrow, time)) << "the job has a slab of its own";
}

TEST(PreviewTime, AnOrderThatTakesMinutesIsReplaced) {
  JobSpec spec = GoodJob();
  spec.mutable_ordering()->mutable_anneal()->set_time_s(600);
  const PointList points_mm = Scatter(100);
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto time = EstimateTime(FrozenOf(spec), {points_mm, masks}, 1000, {}, {});
  ASSERT_TRUE(time);
  EXPECT_EQ(time->order(), "smooth");
}

}  // namespace
}  // namespace intaglio::client
