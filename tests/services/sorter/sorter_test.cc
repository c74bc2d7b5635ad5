// The program as the discretizer, the job service and the synchronizer see it.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "services/platform/bus/error_code.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/host/stage/flow.h"
#include "services/sorter/sort_job.h"
#include "tests/services/platform/host/stage/stage_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using test::Eventually;
using test::FrozenJobOf;
using test::StageShop;
using Clock = std::chrono::steady_clock;

constexpr double kBlock = 30;

JobSpec SortSpec() {
  JobSpec spec;
  spec.add_models()->set_file("/nowhere/cube.stl");
  auto& size = *spec.mutable_block()->mutable_size_mm();
  size.set_x(kBlock), size.set_y(kBlock), size.set_z(kBlock);
  spec.mutable_discretization()->set_min_spacing_mm(0.1);
  return spec;
}

/// The same without annealing, for tests of large streams.
JobSpec QuickSpec() {
  JobSpec spec = SortSpec();
  spec.mutable_ordering()->mutable_smooth();
  return spec;
}

/// Anywhere in the block, on a grid of 0.1 mm, no two in one place.
PointCloud RandomCloud(std::size_t count) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<int> step(30, 270);
  std::set<std::array<int, 3>> places;
  while (places.size() < count) places.insert({step(random), step(random), step(random)});
  PointCloud cloud;
  for (const auto& [x, y, z] : places) {
    cloud.Add(Vec3(x, y, z) / 10.0, static_cast<std::uint32_t>(x % 2));
  }
  return cloud;
}

std::vector<std::array<double, 4>> Rows(const PointCloud& cloud) {
  std::vector<std::array<double, 4>> rows;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.points_mm[i];
    rows.push_back({p.x(), p.y(), p.z(), static_cast<double>(cloud.source[i])});
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// From the definition: points with an earlier one strictly inside their upward cone.
std::uint64_t ShadowViolations(const PointList& made_mm, double cone_tangent) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < made_mm.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 d = made_mm[j] - made_mm[i];
      if (d.head<2>().norm() < cone_tangent * d.z() - 1e-9) {
        ++count;
        break;
      }
    }
  }
  return count;
}

/// Memory of that process, MB.
double ResidentMb(pid_t pid) {
  std::ifstream statm(fmt::format("/proc/{}/statm", pid));
  double all_pages = 0, resident_pages = 0;
  statm >> all_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

class SorterTest : public testing::Test {
 protected:
  SorterTest() { EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY)); }
  /// Plays the discretizer and, when `takes`, the synchronizer.
  Result<PointCloud> Stream(const std::string& job_uid, const PointCloud& cloud,
                            bool takes, host::TaskPart part = {}) {
    sender.Begin(job_uid, 1, part, cloud, Clock::now());
    Result<bool> sent = false, taken = !takes;
    Eventually(
        [&] {
          if (sent && !*sent) sent = sender.Advance(Clock::now());
          if (takes && taken && !*taken) taken = TakePath(job_uid);
          return !sent || !taken || (*sent && *taken);
        },
        20s);
    if (!sent) return tl::unexpected(sent.error());
    if (!taken) return tl::unexpected(taken.error());
    if (!*sent || !*taken) return Fail(ErrorCode::kTimedOut, "the stream is stuck");
    return std::exchange(path, {});
  }
  void OpenPath(const std::string& job_uid) {
    ASSERT_TRUE(credit.Open(bus::PartStreamName(job_uid, 1, bus::kPathBatch.name, 0, 0),
                            path_reader.guid(), 2));
  }

  StageShop shop{"intaglio-sorter", intaglio_STAGE_SORT, bus::kSortTask};
  host::PointSender sender{shop.bus(), bus::kPointBatch, ""};
  bus::Reader<intaglio_PathBatch> path_reader{shop.bus(), bus::kPathBatch};
  bus::CreditGrantor credit{shop.bus(), "synchronizer",
                            bus::RolePartition(bus::CellRole("els-03"))};
  PointCloud path;

 private:
  Result<bool> TakePath(const std::string& job_uid) {
    bool last = false;
    path_reader.Take([&](const intaglio_PathBatch& batch) {
      EXPECT_EQ(bus::View(batch.job_uid), job_uid);
      EXPECT_EQ(batch.first_index, path.size());
      const auto x = bus::View(batch.x_mm), y = bus::View(batch.y_mm),
                 z = bus::View(batch.z_mm);
      for (std::size_t i = 0; i < x.size(); ++i) {
        path.Add(Vec3(x[i], y[i], z[i]), bus::View(batch.source)[i]);
      }
      last = batch.last;
      (void)credit.Consumed(bus::PartStreamName(job_uid, 1, bus::kPathBatch.name, 0, 0),
                            batch.sequence_number + 1, last);
    });
    return last;
  }
};

// On a computer that is busy with millions of points others answer in time.
TEST_F(SorterTest, GivesWayWithItsLoopAndNotWithTheThreadsOfTheBus) {
  const int ours = getpriority(PRIO_PROCESS, 0);
  EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(shop.worker().pid())), 10);
  int as_ours = 0;
  const auto tasks = fmt::format("/proc/{}/task", shop.worker().pid());
  for (const auto& task : std::filesystem::directory_iterator(tasks)) {
    const auto thread = static_cast<id_t>(std::stoi(task.path().filename().string()));
    as_ours += getpriority(PRIO_PROCESS, thread) == ours ? 1 : 0;
  }
  EXPECT_GT(as_ours, 2) << "it reports its health, and acknowledges";
}

TEST_F(SorterTest, OrdersTheCloudWithoutShadows) {
  const PointCloud cloud = RandomCloud(3000);
  OpenPath("sort");
  shop.Give(FrozenJobOf("sort", SortSpec()), 1, "synchronizer");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  const auto ordered = Stream("sort", cloud, true);
  ASSERT_TRUE(ordered) << ordered.error().message;

  EXPECT_EQ(Rows(*ordered), Rows(cloud)) << "the same points, each once";
  // The tangent of the fixture's cone is 0.1.
  EXPECT_EQ(ShadowViolations(ordered->points_mm, 0.1), 0u);
  double travel_mm = 0;
  for (std::size_t i = 1; i < ordered->size(); ++i) {
    travel_mm +=
        (ordered->points_mm[i] - ordered->points_mm[i - 1]).cwiseAbs().maxCoeff();
  }
  const auto end = shop.AwaitEnd("sort", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_DONE) << end->message;
  EXPECT_EQ(end->outcome.sort().point_count(), cloud.size());
  EXPECT_GE(end->estimate_ticks, cloud.size() - 1) << "a tick for each point at least";
  EXPECT_EQ(end->outcome.sort().shadow_violation_count(), 0u);
  // Sums of 3000 numbers, added in the same order or another.
  EXPECT_NEAR(end->outcome.sort().travel_mm(), travel_mm, 1e-6);
}

// One model in two blocks, the other in one of them.
TEST_F(SorterTest, OrdersByChannelsWithFewChanges) {
  JobSpec spec = SortSpec();
  spec.add_models()->set_file("/nowhere/ball.stl");
  spec.mutable_laser()->add_channels(1);
  spec.mutable_laser()->add_channels(2);
  spec.mutable_models(1)->add_channels(2);
  const PointCloud cloud = RandomCloud(3000);
  OpenPath("channels");
  shop.Give(FrozenJobOf("channels", spec), 1, "synchronizer");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  const auto ordered = Stream("channels", cloud, true);
  ASSERT_TRUE(ordered) << ordered.error().message;
  EXPECT_EQ(Rows(*ordered), Rows(cloud));
  // All are in the second block: none is made through an earlier crack.
  EXPECT_EQ(ShadowViolations(ordered->points_mm, 0.1), 0u);
  std::size_t changes = 0;
  for (std::size_t i = 1; i < ordered->size(); ++i) {
    changes += ordered->source[i] != ordered->source[i - 1] ? 1 : 0;
  }
  const auto end = shop.AwaitEnd("channels", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->outcome.sort().shadow_violation_count(), 0u);
  EXPECT_EQ(end->outcome.sort().shutter_change_count(), changes);
  EXPECT_LT(changes, 40u) << "of 3000 points, every other one of the other channels";
}

TEST_F(SorterTest, StreamsMoreThanItsCreditWithoutLoss) {
  const PointCloud cloud = RandomCloud(60'000);  // 8 batches under a window of 2
  OpenPath("long");
  shop.Give(FrozenJobOf("long", QuickSpec()), 1, "synchronizer");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  const auto ordered = Stream("long", cloud, true);
  ASSERT_TRUE(ordered) << ordered.error().message;
  EXPECT_EQ(Rows(*ordered), Rows(cloud));
}

TEST_F(SorterTest, WithoutAConsumerOnlyTheOutcomeIsReported) {
  shop.Give(FrozenJobOf("alone", SortSpec()), 1, "");
  ASSERT_TRUE(Stream("alone", RandomCloud(100), false));
  const auto end = shop.AwaitEnd("alone", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->state, intaglio_TASK_DONE) << end->message;
  EXPECT_EQ(end->outcome.sort().point_count(), 100u);
}

TEST_F(SorterTest, TakesACloudInPartsAndOneOfThemTwice) {
  const PointCloud cloud = RandomCloud(30'000);
  OpenPath("whole");
  shop.Give(FrozenJobOf("whole", QuickSpec()), 1, "synchronizer");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  const auto of_one = Stream("whole", cloud, true);
  ASSERT_TRUE(of_one) << of_one.error().message;
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));

  OpenPath("parts");
  shop.Give(FrozenJobOf("parts", QuickSpec()), 1, "synchronizer", {}, 3);
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  const auto piece = [&cloud](std::size_t part) {
    PointCloud points;
    for (std::size_t i = part * 10'000; i < (part + 1) * 10'000; ++i) {
      points.Add(cloud.points_mm[i], cloud.source[i]);
    }
    return points;
  };
  for (const host::TaskPart part : {host::TaskPart{2, 3, 0}, {0, 3, 0}, {2, 3, 1}}) {
    sender.Begin("parts", 1, part, piece(part.index), Clock::now());
    Result<bool> sent = false;
    ASSERT_TRUE(
        Eventually([&] { return sent = sender.Advance(Clock::now()), !sent || *sent; }));
    ASSERT_TRUE(sent) << sent.error().message;
  }
  const auto of_three = Stream("parts", piece(1), true, {1, 3, 2});
  ASSERT_TRUE(of_three) << of_three.error().message;
  EXPECT_EQ(of_three->points_mm, of_one->points_mm);
  EXPECT_EQ(of_three->source, of_one->source);
}

TEST_F(SorterTest, RefusesACloudWithoutPoints) {
  shop.Give(FrozenJobOf("empty", SortSpec()), 1, "");
  ASSERT_TRUE(Stream("empty", {}, false));
  const auto end = shop.AwaitEnd("empty", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kMissing)) << end->message;
}

TEST_F(SorterTest, ADiscretizerThatNeverSendsIsEndedByRevoking) {
  shop.Give(FrozenJobOf("waits", SortSpec()), 1, "");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  shop.Revoke("waits", 1);
  const auto end = shop.AwaitEnd("waits", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kCancelled));
  EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
}

TEST_F(SorterTest, AnnealsForAsLongAsTheJobStates) {
  JobSpec spec = SortSpec();
  spec.mutable_ordering()->mutable_anneal()->set_time_s(0.5);
  const PointCloud cloud = RandomCloud(2000);
  OpenPath("timed");
  const auto began = Clock::now();
  shop.Give(FrozenJobOf("timed", spec), 1, "synchronizer");
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
  const auto ordered = Stream("timed", cloud, true);
  ASSERT_TRUE(ordered) << ordered.error().message;
  EXPECT_GE(Clock::now() - began, 500ms);
  EXPECT_EQ(Rows(*ordered), Rows(cloud));
  EXPECT_EQ(ShadowViolations(ordered->points_mm, 0.1), 0u);
}

TEST_F(SorterTest, AnnealingIsEndedByRevoking) {
  JobSpec spec = SortSpec();
  spec.mutable_ordering()->mutable_anneal()->set_time_s(3600);
  shop.Give(FrozenJobOf("endless", spec), 1, "");
  ASSERT_TRUE(Stream("endless", RandomCloud(1000), false));
  shop.Revoke("endless", 1);
  const auto end = shop.AwaitEnd("endless", 1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, bus::WireOf(ErrorCode::kCancelled));
}

// Batches of other sorters' jobs reach every reader; a worker that computes for an hour
// may not keep them.
TEST_F(SorterTest, WhatIsSentToOthersDoesNotPileUpWhileItComputes) {
  JobSpec spec = SortSpec();
  spec.mutable_ordering()->mutable_anneal()->set_time_s(3600);
  shop.Give(FrozenJobOf("hour", spec), 1, "");
  ASSERT_TRUE(Stream("hour", RandomCloud(1000), false));

  bus::Writer<intaglio_PointBatch> writer(shop.bus(), bus::kPointBatch);
  ASSERT_TRUE(Eventually([&] { return writer.matched_count() > 0; }));
  const std::string job_uid = "of another sorter";
  const std::vector<double> column(host::kBatchPoints);
  intaglio_PointBatch batch{};
  batch.job_uid = bus::Borrow(job_uid);
  bus::Borrow(batch.x_mm, column);
  bus::Borrow(batch.y_mm, column);
  bus::Borrow(batch.z_mm, column);
  const double before_mb = ResidentMb(shop.worker().pid());
  constexpr int kBatches = 400;  // 79 MB
  for (int i = 0; i < kBatches; ++i) {
    ASSERT_TRUE(Eventually([&] { return writer.Write(batch).has_value(); }));
    // The window of a credit: no more than this is under way to a worker that takes it.
    if (i % 32 == 31) {
      ASSERT_TRUE(writer.WaitForAcknowledgements(5s));
    }
  }
  ASSERT_TRUE(writer.WaitForAcknowledgements(5s));
  // A few windows' worth of slack for buffers that are not given back.
  EXPECT_TRUE(Eventually([&] {
    return ResidentMb(shop.worker().pid()) < before_mb + 25;
  })) << ResidentMb(shop.worker().pid()) - before_mb
      << " MB more";
}

TEST_F(SorterTest, WrongOptionsFailTheTaskAndTheNextOneIsDone) {
  JobSpec spec = SortSpec();
  spec.mutable_ordering()->mutable_kdz()->set_up_ratio(-5);
  shop.Give(FrozenJobOf("wrong", spec), 1, "");
  ASSERT_TRUE(Stream("wrong", RandomCloud(10), false));
  const auto wrong = shop.AwaitEnd("wrong", 1);
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->error_code, bus::WireOf(ErrorCode::kInvalidValue)) << wrong->message;

  shop.Give(FrozenJobOf("right", SortSpec()), 1, "");
  ASSERT_TRUE(Stream("right", RandomCloud(10), false));
  const auto right = shop.AwaitEnd("right", 1);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->state, intaglio_TASK_DONE) << right->message;
}

// The order decides the largest speed of a web: nothing is armed or begun before.
TEST_F(SorterTest, AWebThatIsTooFastIsRefusedBeforeItIsArmed) {
  FrozenJob job = FrozenJobOf("web", SortSpec());
  job.mutable_machine()->mutable_scan_head()->set_field_mm(60);
  job.mutable_machine()->mutable_scan_head()->set_jump_mm_s(5000);
  job.mutable_job()->Clear();
  job.mutable_job()->mutable_marks()->add_items()->mutable_code()->set_text("A");
  job.mutable_job()->mutable_marks()->mutable_web()->set_speed_mm_s(500);
  // A second of marking, of which 4 mm are in the field for 112 ms.
  mark::MarkSet set;
  set.pens = {{"item 1", 4, 0.5, 20000, 1}};
  set.marks = {{0, false, 0, {{{0, 0}, 0}, {{4, 0}, 0}}}};
  host::MarkSender marks(shop.bus(), bus::kMarkBatch, "");
  const auto end_of = [&](const std::string& uid) {
    job.set_job_uid(uid);
    shop.Give(job, 1, "");
    EXPECT_TRUE(shop.AwaitHealth(intaglio_HEALTH_BUSY));
    marks.Begin(uid, 1, {}, set, Clock::now());
    EXPECT_TRUE(
        Eventually([&] { return marks.Advance(Clock::now()).value_or(true); }, 20s));
    return shop.AwaitEnd(uid, 1);
  };
  const auto refused = end_of("web");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->state, intaglio_TASK_FAILED);
  EXPECT_EQ(refused->error_code, bus::WireOf(ErrorCode::kRefused));
  EXPECT_NE(refused->message.find("marks.web.speed_mm_s: at 500 mm/s 1 of 1 mark would "
                                  "be missed, the first: item 1 of repeat 1; the largest "
                                  "speed is 55."),
            std::string::npos)
      << refused->message;
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
  job.mutable_job()->mutable_marks()->mutable_web()->set_speed_mm_s(0);
  const auto chosen = end_of("as fast as possible");
  ASSERT_TRUE(chosen);
  EXPECT_EQ(chosen->state, intaglio_TASK_DONE) << chosen->message;
  ASSERT_EQ(chosen->outcome.sort().warnings_size(), 1);
  EXPECT_EQ(chosen->outcome.sort().warnings(0).code(), "chosen");
}

TEST(SortMarks, CountsMarksAndEndsWhenItIsAskedTo) {
  FrozenJob job = FrozenJobOf("web", SortSpec());
  job.mutable_machine()->mutable_scan_head()->set_field_mm(60);
  job.mutable_machine()->mutable_scan_head()->set_jump_mm_s(5000);
  job.mutable_job()->Clear();
  job.mutable_job()->mutable_marks()->add_items()->mutable_code()->set_text("A");
  job.mutable_job()->mutable_marks()->mutable_web()->set_speed_mm_s(0);
  mark::MarkSet set;
  set.pens = {{"item 1", 1000, 0.5, 20000, 1}};
  for (int k = 0; k < 50; ++k)
    set.marks.push_back({0, false, 40.0 * k, {{{0, 0}, 0}, {{4, 0}, 0}}});
  std::set<std::uint64_t> counted;
  const auto ordered =
      sorter::SortMarks(job, set, [&](std::uint64_t done, std::uint64_t total) {
        EXPECT_EQ(total, 50U);
        counted.insert(done);
        return true;
      });
  ASSERT_TRUE(ordered) << ordered.error().message;
  EXPECT_EQ(counted.size(), 51U);
  const auto ended = sorter::SortMarks(
      job, set, [](std::uint64_t done, std::uint64_t) { return done < 20; });
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace intaglio
