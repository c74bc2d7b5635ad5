#include "services/synchronizer/job_planner.h"

#include <gmock/gmock.h>
#include <time.h>

#include <thread>

#include "services/job/plan/predicted_errors.h"
#include "services/synchronizer/job_folder.h"
#include "tests/patience.h"
#include "tests/sanitizers.h"
#include "tests/services/synchronizer/good_task.h"
#include "tests/test_folder.h"

namespace intaglio::synchronizer {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

constexpr bool kSanitized = test::kSanitizersTake > 1;

/// That of this thread alone: what others do on the computer does not count.
std::chrono::nanoseconds ProcessorTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Rows to and fro, layer upon layer, in the sample's block of 50 x 50 x 30 mm.
PointCloud PathOf(std::size_t count) {
  constexpr std::size_t kRow = 100;
  PointCloud path;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t row = i / kRow, layer = row / kRow;
    const std::size_t along = row % 2 == 0 ? i % kRow : kRow - 1 - i % kRow;
    const std::size_t across = layer % 2 == 0 ? row % kRow : kRow - 1 - row % kRow;
    path.Add(
        Vec3(5 + 0.4 * static_cast<double>(along), 5 + 0.4 * static_cast<double>(across),
             3 + 0.24 * static_cast<double>(layer)),
        0);
  }
  return path;
}

class JobPlannerTest : public testing::Test {
 protected:
  PreparationTask TaskOf(PointCloud path) const {
    FrozenJob job = GoodTask();
    job.set_result_directory(folder_.string());
    for (AxisLimits* axis :
         {job.mutable_machine()->mutable_x(), job.mutable_machine()->mutable_y(),
          job.mutable_machine()->mutable_z()}) {
      axis->set_max_jerk_mm_s3(1e6);
    }
    return {job, std::move(path), ""};
  }
  /// Calls `done` as a loop does, until it is true; false after two minutes.
  template <typename Done>
  bool TurnUntil(const Done& done) {
    const test::Patience patience(120s);
    while (!patience.over()) {
      const auto before = ProcessorTime();
      const bool is_done = done();
      longest_turn_ = std::max(longest_turn_, ProcessorTime() - before);
      if (is_done) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }
  bool Prepares() {
    return TurnUntil(
        [this] { return (prepared_ = planner_.TakePrepared()).has_value(); });
  }

  std::filesystem::path folder_ = test::FreshFolder();
  JobPlanner planner_;
  std::optional<Result<PreparedJob>> prepared_;
  std::chrono::nanoseconds longest_turn_{0};
};

// On the old code the loop planned all of it before the first point: seconds without a
// turn, where the permission is fresh for 90 ms.
TEST_F(JobPlannerTest, AMillionPointsWithLimitsOfTheJerkKeepTheLoopWaitingForNothing) {
  const std::size_t count = kSanitized ? 50'000 : 1'000'000;
  planner_.Begin(TaskOf(PathOf(count)));
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_) << prepared_->error().message;
  // The first window is planned while the whole is not.
  std::vector<motion::Segment> out;
  const EngravingJob& job = (*prepared_)->engraving;
  ASSERT_EQ(job.machine_points_mm.size(), count);
  auto feed = motion::MakePlanner(job.plan, job.machine_points_mm.front());
  std::size_t fed = 0;
  ASSERT_TRUE(TurnUntil([&] {
    for (const std::size_t end = fed + 16; fed < end; ++fed) {
      feed->Append(job.machine_points_mm[fed], static_cast<std::int32_t>(fed), true, out);
    }
    return feed->ticks() >= 200;  // a second of the lamp
  }));
  EXPECT_EQ(planner_.summary(), nullptr)
      << "nothing is shown if the whole is planned by now";
  EXPECT_TRUE(TurnUntil([this] { return planner_.Abandon(), true; }));
  EXPECT_LT(longest_turn_, kSanitized ? 1s : 50ms);
  std::cout << "longest turn " << longest_turn_ / 1us << " us of processor time, first "
            << fed << " points planned before the whole\n";
}

TEST_F(JobPlannerTest, TheSummaryIsThatOfThePlanMadeAtOnce) {
  planner_.Begin(TaskOf(PathOf(5000)));
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_);
  const EngravingJob& job = (*prepared_)->engraving;
  const auto at_once = Summarize({job.machine_points_mm, job.plan, job.masks},
                                 [](std::uint64_t, std::uint64_t) { return true; });
  const Result<PlanSummary>* summary = nullptr;
  ASSERT_TRUE(TurnUntil([&] { return (summary = planner_.summary()) != nullptr; }));
  EXPECT_EQ((*summary)->checksum, at_once->checksum);
  EXPECT_EQ((*summary)->ticks, at_once->ticks);
}

// From the commands that the machine gets, and as `intaglio plan` does it from the motion
// before its compensation.
TEST_F(JobPlannerTest, TheSummaryHasTheErrorsThatThePlannedMotionWillHave) {
  const PreparationTask task = TaskOf(PathOf(500));
  planner_.Begin(task);
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_);
  const EngravingJob job = (*prepared_)->engraving;
  PredictedErrors expected(task.job, job.machine_points_mm);
  motion::PlanOptions options = job.plan;
  options.compensated = false;
  PlanInput plan{job.machine_points_mm, options, job.masks};
  plan.follow = [&](const motion::Segment& planned) { expected.Append(planned); };
  ASSERT_TRUE(Summarize(plan, [](std::uint64_t, std::uint64_t) { return true; }));
  expected.Finish();
  const Result<PlanSummary>* summary = nullptr;
  ASSERT_TRUE(TurnUntil([&] { return (summary = planner_.summary()) != nullptr; }));
  ASSERT_TRUE(*summary && (*summary)->predicted);
  const PredictedSummary& predicted = *(*summary)->predicted;
  EXPECT_GT(predicted.max_um, 0);
  EXPECT_GT(predicted.wrong_mechanics_max_um, predicted.max_um / 2);
  EXPECT_NEAR(predicted.max_um, expected.max_um(), 1e-6 * expected.max_um());
  EXPECT_NEAR(predicted.rms_um, expected.rms_um(), 1e-6 * expected.rms_um());
  EXPECT_NEAR(predicted.wrong_mechanics_max_um, expected.wrong_mechanics_max_um(),
              1e-6 * expected.wrong_mechanics_max_um());
}

TEST_F(JobPlannerTest, WhatIsPreparedLiesInTheFolderAndIsTakenUpFromThere) {
  planner_.Begin(TaskOf(PathOf(500)));
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_);
  const PointList points_mm = (*prepared_)->engraving.machine_points_mm;
  EXPECT_TRUE(std::filesystem::exists(folder_ / kPathFile));
  EXPECT_TRUE(std::filesystem::exists(folder_ / kJournalFile));
  prepared_.reset();
  PreparationTask again = TaskOf({});
  again.path.reset();
  planner_.Begin(again);
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_) << prepared_->error().message;
  EXPECT_EQ((*prepared_)->engraving.machine_points_mm, points_mm);
}

// A table that rises to the lens counts up where the focus goes down: what lies above a
// point is decided by places, and motion by axes.
TEST_F(JobPlannerTest, AxesThatAreNoPlacesAreKeptBesideThem) {
  PreparationTask task = TaskOf(PathOf(500));
  const PointList glass_mm = task.path->points_mm;
  const double ratio = task.job.optics().stage_per_glass_ratio();
  MachineSpec& machine = *task.job.mutable_machine();
  machine.mutable_cartesian()->mutable_z()->set_moves(AXIS_MOVES_TABLE);
  machine.mutable_block_origin_mm()->set_z(-50);
  planner_.Begin(std::move(task));
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_) << prepared_->error().message;
  const EngravingJob& job = (*prepared_)->engraving;
  ASSERT_EQ(job.places_mm.size(), glass_mm.size());
  for (std::size_t i = 0; i < glass_mm.size(); ++i) {
    // The top of the block of 30 mm is at -20.
    const Vec3 place_mm(glass_mm[i].x(), glass_mm[i].y(),
                        -20 - (30 - glass_mm[i].z()) * ratio);
    EXPECT_LT((job.places_mm[i] - place_mm).norm(), 1e-12);
    EXPECT_EQ(job.machine_points_mm[i].z(), -job.places_mm[i].z());
    EXPECT_LT(
        (job.machine_from_glass.ToGlass(job.machine_points_mm[i]) - glass_mm[i]).norm(),
        1e-12);
  }
  planner_.Begin(TaskOf(PathOf(500)));
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_) << prepared_->error().message;
  EXPECT_TRUE((*prepared_)->engraving.places_mm.empty()) << "a head's axes are places";
}

TEST_F(JobPlannerTest, APathOutsideTheBlockIsRefusedAndNothingIsWritten) {
  PointCloud path = PathOf(10);
  path.points_mm[7].x() = 50.5;
  planner_.Begin(TaskOf(path));
  ASSERT_TRUE(Prepares());
  ASSERT_FALSE(*prepared_);
  EXPECT_EQ(prepared_->error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(prepared_->error().message, HasSubstr("point 7 of the order"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / kPathFile));
}

TEST_F(JobPlannerTest, AnAbandonedTaskIsNeverSeenAndTheNextOneWaitsForItsEnd) {
  planner_.Begin(TaskOf(PathOf(kSanitized ? 20'000 : 200'000)));
  EXPECT_FALSE(planner_.TakePrepared());
  planner_.Abandon();
  EXPECT_FALSE(planner_.TakePrepared());
  planner_.Begin(TaskOf(PathOf(300)));
  ASSERT_TRUE(Prepares());
  ASSERT_TRUE(*prepared_) << prepared_->error().message;
  EXPECT_EQ((*prepared_)->engraving.machine_points_mm.size(), 300);
  EXPECT_EQ(ReadPath(folder_)->size(), 300);
  EXPECT_FALSE(planner_.TakePrepared()) << "once";
}

}  // namespace
}  // namespace intaglio::synchronizer
