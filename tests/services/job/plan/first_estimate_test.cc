// The estimate of a part of the cloud against the plan of the whole.

#include "services/job/plan/first_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

#include "engrave/formats/point_file_kinds.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/options.h"
#include "services/job/plan/point_order.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

FrozenJob SampleJob(double rate_hz) {
  FrozenJob frozen;
  *frozen.mutable_machine() = GoodMachine();
  JobSpec job = GoodJob();
  job.mutable_laser()->set_rate_hz(rate_hz);
  *frozen.mutable_job() = WithDefaults(job, frozen.machine());
  frozen.mutable_optics()->set_refractive_index(1.5195);
  frozen.mutable_optics()->set_stage_per_glass_ratio(0.655);
  frozen.mutable_optics()->set_cone_tangent(0.12);
  return frozen;
}

/// Ticks of the estimate by parts, over those of the whole.
double RatioOf(const FrozenJob& job, const PointList& points_mm,
               const EstimateOptions& options) {
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto estimate = FirstEstimateTicks(job, points_mm, masks, {}, {}, options);
  const auto whole =
      FirstEstimateTicks(job, points_mm, masks, {}, {}, {1, points_mm.size()});
  EXPECT_TRUE(estimate) << (estimate ? "" : estimate.error().message);
  EXPECT_TRUE(whole);
  if (!estimate || !whole) return 0;
  return static_cast<double>(*estimate) / static_cast<double>(*whole);
}

constexpr EstimateOptions kParts{4, 1000};
constexpr double kTolerance = 0.15;

/// A lattice of 0.3 mm on a ball of 22 mm, in the middle of the block.
PointList Ball() {
  PointList points_mm;
  const double radius = 11, spacing = 0.3;
  const int count = static_cast<int>(4 * std::numbers::pi * radius * radius /
                                     (spacing * spacing * std::sqrt(3) / 2));
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - z * z);
    points_mm.push_back(Vec3(25, 25, 15) + radius * Vec3(r * std::cos(golden * i),
                                                         r * std::sin(golden * i), z));
  }
  return points_mm;
}

/// Circles of points 0.3 mm apart, as sections of a cone.
PointList Sections() {
  PointList points_mm;
  for (double z = 0; z < 20; z += 0.3) {
    const double radius = 4 + 0.3 * z;
    const int count = static_cast<int>(2 * std::numbers::pi * radius / 0.3);
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      points_mm.push_back(
          {25 + radius * std::cos(angle), 25 + radius * std::sin(angle), 5 + z});
    }
  }
  return points_mm;
}

/// A flat panel of points at random, as of a photo.
PointList Panel() {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> along(5, 45);
  PointList points_mm;
  for (int i = 0; i < 12000; ++i) points_mm.push_back({along(random), along(random), 15});
  return points_mm;
}

TEST(FirstEstimate, OfPartsIsThatOfTheWhole) {
  for (const double rate_hz : {50.0, 200.0}) {
    const FrozenJob job = SampleJob(rate_hz);
    EXPECT_NEAR(RatioOf(job, Ball(), kParts), 1, kTolerance) << "ball, " << rate_hz;
    EXPECT_NEAR(RatioOf(job, Sections(), kParts), 1, kTolerance) << "cone, " << rate_hz;
    EXPECT_NEAR(RatioOf(job, Panel(), kParts), 1, kTolerance) << "panel, " << rate_hz;
  }
}

// A slow axis that starts and stops in each part took many of its ticks.
TEST(FirstEstimate, OfPartsOfASweepIsThatOfTheWhole) {
  FrozenJob job = SampleJob(4000);
  job.mutable_job()->mutable_ordering()->mutable_sweep()->set_slab_mm(0.05);
  job.mutable_job()->mutable_motion()->set_depth_tolerance_um(50);
  MachineSpec& machine = *job.mutable_machine();
  for (AxisLimits* mirror : {machine.mutable_x(), machine.mutable_y()}) {
    mirror->set_max_speed_mm_s(8000);
    mirror->set_max_acceleration_mm_s2(5e7);
  }
  machine.mutable_z()->set_max_speed_mm_s(50);
  machine.mutable_z()->set_max_acceleration_mm_s2(1000);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> across(5, 45), up(4, 14);
  PointList points_mm;
  for (int i = 0; i < 30000; ++i)
    points_mm.push_back({across(random), across(random), up(random)});
  EXPECT_NEAR(RatioOf(job, points_mm, {4, 400}), 1, 0.05);
}

TEST(FirstEstimate, AddsTheChannelsThatAreMadeOneAfterAnother) {
  const FrozenJob job = SampleJob(200);
  const PointList points_mm = Sections();
  std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto one = FirstEstimateTicks(job, points_mm, masks, {}, {}, kParts);
  for (std::size_t i = 0; i < masks.size() / 2; ++i) masks[i] = 2;
  const auto two = FirstEstimateTicks(job, points_mm, masks, {}, {}, kParts);
  ASSERT_TRUE(one && two);
  EXPECT_NEAR(static_cast<double>(*two) / static_cast<double>(*one), 1, 0.1);
}

// So a sorter plans its order in the place of an estimate.
TEST(FirstEstimate, OfASmallCloudIsThePlanOfItsOrder) {
  FrozenJob job = SampleJob(200);
  PointList points_mm = Sections();
  ASSERT_FALSE(EstimatesWhole(job, 10'001));
  points_mm.resize(std::min<std::size_t>(points_mm.size(), 1000));
  ASSERT_TRUE(EstimatesWhole(job, points_mm.size()));
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto go_on = [](std::uint64_t, std::uint64_t) { return true; };
  const auto order =
      OrderPoints(job, points_mm, masks, OrderOptionsOf(job), go_on).value();
  EXPECT_EQ(FirstEstimateTicks(job, points_mm, masks, {}, {}).value(),
            SummarizeOrder(job, points_mm, masks, order, go_on).value().ticks);
  job.mutable_job()->mutable_ordering()->mutable_anneal()->set_time_s(60);
  EXPECT_FALSE(EstimatesWhole(job, points_mm.size())) << "the order takes a minute";
}

TEST(FirstEstimate, OfOnePointIsNothingAndEndsWhenCancelled) {
  const FrozenJob job = SampleJob(200);
  const std::vector<ChannelMask> one(1, 1);
  EXPECT_EQ(*FirstEstimateTicks(job, {Vec3(25, 25, 15)}, one, {}, {}), 0u);
  const PointList points_mm = Sections();
  const std::vector<ChannelMask> masks(points_mm.size(), 1);
  const auto cancelled = FirstEstimateTicks(
      job, points_mm, masks, {}, [](std::uint64_t, std::uint64_t) { return false; });
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, ErrorCode::kCancelled);
}

// INTAGLIO_ESTIMATE_OF=cloud.ply: prints the ratio for a cloud in a block of the sample.
TEST(FirstEstimate, OfAGivenCloud) {
  const char* file = std::getenv("INTAGLIO_ESTIMATE_OF");
  if (file == nullptr) GTEST_SKIP() << "set INTAGLIO_ESTIMATE_OF to a cloud";
  const auto table = formats::ReadPoints(file);
  ASSERT_TRUE(table) << table.error().message;
  for (const double rate_hz : {50.0, 100.0, 200.0}) {
    const double ratio = RatioOf(SampleJob(rate_hz), table->points_mm, {});
    std::printf("%s %zu points, %g Hz: %.3f\n", file, table->points_mm.size(), rate_hz,
                ratio);
  }
}

}  // namespace
}  // namespace intaglio
