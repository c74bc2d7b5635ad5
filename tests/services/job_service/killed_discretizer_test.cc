// The real job service and real discretizers as processes; client, sorter and
// synchronizer are played by the test. One discretizer is killed in the middle of a part.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <set>
#include <thread>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/flow.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using bus::View;
using test::ChildProgram;
using test::Eventually;
using testing::HasSubstr;

/// Half a million points or so: parts of a tenth of a second at least.
JobSpec LongJob() {
  JobSpec job = GoodJob();
  job.mutable_discretization()->set_min_spacing_mm(0.04);
  return job;
}

struct PartReport {
  std::string job_uid, worker;
  std::uint32_t part = 0, part_attempt = 0;
  intaglio_TaskState state = intaglio_TASK_ACCEPTED;
};

constexpr std::chrono::seconds kSignPeriod{1};

class KilledDiscretizerTest : public testing::Test {
 protected:
  KilledDiscretizerTest() : folder_(test::FreshFolder()) {
    service_.emplace(folder_, test::PrivateTag());
  }
  static std::unique_ptr<ChildProgram> Discretizer() {
    return std::make_unique<ChildProgram>(
        INTAGLIO_BIN_DIR "/intaglio-discretizer",
        std::vector<std::string>{"--tag", test::PrivateTag(), "--die-with-parent",
                                 "--threads", "1", "--log-level", "error"});
  }
  /// The instance of this process, when it is there.
  std::string InstanceOf(ChildProgram& discretizer) {
    std::string instance;
    EXPECT_TRUE(Eventually([&] {
      health_.Take([&](const intaglio_ServiceHealth& sample) {
        if (sample.pid == discretizer.pid()) instance = View(sample.instance);
      });
      return !instance.empty();
    }));
    return instance;
  }
  /// Sorter and synchronizer are at their tasks, however long a busy computer takes for
  /// the parts: the job service gives up who is silent for 10 s.
  void GiveSignsOfLife(const TaskCopy& sort) {
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
    shop_.Report(sort, intaglio_STAGE_SORT, intaglio_TASK_RUNNING, 0, 0);
    shop_.Report(shop_.Task(intaglio_STAGE_ENGRAVE), intaglio_STAGE_ENGRAVE,
                 intaglio_TASK_RUNNING, 0, 0);
  }
  /// Plays the sorter's intake until it has the whole cloud. `look` is called between.
  PointCloud Receive(const TaskCopy& sort, const std::function<void()>& period) {
    EXPECT_TRUE(intake_.Open(sort.job_uid, sort.attempt, sort.input_part_count));
    Result<bool> taken = false;
    auto next_sign = std::chrono::steady_clock::now();
    Eventually(
        [&] {
          if (std::chrono::steady_clock::now() >= next_sign) {
            GiveSignsOfLife(sort);
            next_sign = std::chrono::steady_clock::now() + kSignPeriod;
          }
          period();
          taken = intake_.Poll();
          return !taken || *taken;
        },
        std::chrono::seconds(60));
    EXPECT_TRUE(taken && *taken) << (taken ? "not whole" : taken.error().message);
    return taken && *taken ? intake_.TakeContent() : PointCloud();
  }
  /// As Begin, until the job service had seen so many discretizers that the job is in
  /// this many parts.
  TaskCopy BeginInParts(std::uint32_t part_count, std::string& submission) {
    for (int i = 0; i < 5; ++i) {
      submission = fmt::format("{} parts {}", part_count, i);
      const TaskCopy sort = Begin(submission);
      if (sort.input_part_count == part_count || HasFailure()) return sort;
      shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_BUSY);
      Cancel(submission);
      // Longer than a revoked worker is kept aside: both are free for the next try.
      std::this_thread::sleep_for(std::chrono::milliseconds(1500));
      shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    }
    ADD_FAILURE() << "the job service does not see the discretizers";
    return {};
  }
  /// Submits the job and waits for the sorter's task.
  TaskCopy Begin(const std::string& submission) {
    shop_.Submit(submission, LongJob());
    EXPECT_TRUE(shop_.Until([&] {
      return shop_.Status(submission).state == intaglio_JOB_DISCRETIZING;
    })) << shop_.Status(submission).message;
    TaskCopy task;
    EXPECT_TRUE(shop_.Until([&] {
      task = shop_.Task(intaglio_STAGE_SORT);
      return task.job_uid == shop_.Status(submission).uid && !task.revoked;
    }));
    return task;
  }
  void Cancel(const std::string& submission) {
    shop_.Command(shop_.Status(submission), intaglio_COMMAND_CANCEL, 1, false,
                  submission);
    ASSERT_TRUE(shop_.Until(
        [&] { return shop_.Status(submission).state == intaglio_JOB_CANCELLED; }));
    const TaskCopy sort = shop_.Task(intaglio_STAGE_SORT);
    const TaskCopy engrave = shop_.Task(intaglio_STAGE_ENGRAVE);
    shop_.Report(sort, intaglio_STAGE_SORT, intaglio_TASK_FAILED, 0, 0,
                 intaglio_ERROR_CANCELLED, "");
    shop_.Report(engrave, intaglio_STAGE_ENGRAVE, intaglio_TASK_FAILED, 0, 0,
                 intaglio_ERROR_CANCELLED, "");
  }
  std::vector<PartReport> TakeReports() {
    std::vector<PartReport> reports;
    statuses_.Take([&](const intaglio_TaskStatus& sample) {
      if (sample.stage != intaglio_STAGE_DISCRETIZE) return;
      reports.push_back({std::string(View(sample.job_uid)),
                         std::string(View(sample.worker)), sample.part,
                         sample.part_attempt, sample.state});
    });
    return reports;
  }

  fs::path folder_;
  bus::Bus bus_{test::PrivateBusOptions("", bus::kStageWorkerRole)};
  FakeShop shop_{test::PrivateBusOptions()};
  bus::Reader<intaglio_ServiceHealth> health_{bus_, bus::kServiceHealth};
  bus::Reader<intaglio_TaskStatus> statuses_{bus_, bus::kTaskStatus};
  host::PointIntake intake_{bus_, "s", bus::kPointBatch};
  std::optional<ServiceProcess> service_;
};

/// What became of the parts of a job, as the discretizers report.
struct PartReports {
  std::set<std::uint32_t> begun_by_victim, made_again;
};

class DisturbedDiscretizerTest : public KilledDiscretizerTest {
 protected:
  DisturbedDiscretizerTest() {
    victim_ = Discretizer();
    other_ = Discretizer();
    victim_name_ = InstanceOf(*victim_);
    EXPECT_FALSE(InstanceOf(*other_).empty());
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
  }
  /// The cloud of both, with `disturb` called between until the end.
  PointCloud CloudOfTwo(const std::function<void(const PartReports&)>& disturb) {
    const TaskCopy sort = BeginInParts(16, submission_);
    return Receive(sort, [&] {
      for (const PartReport& report : TakeReports()) {
        if (report.job_uid != sort.job_uid) continue;
        if (report.worker == victim_name_) reports_.begun_by_victim.insert(report.part);
        if (report.part_attempt > 0) reports_.made_again.insert(report.part);
      }
      disturb(reports_);
    });
  }
  /// The job went on without a new attempt; it has a cloud of the same bits from one.
  void ExpectTheCloudOfOne(const PointCloud& of_two) {
    EXPECT_EQ(shop_.Status(submission_).attempt, 1u);
    EXPECT_THAT(shop_.Status(submission_).message,
                HasSubstr("starts again: " + victim_name_));
    ASSERT_TRUE(shop_.Until(
        [&] { return shop_.Status(submission_).state == intaglio_JOB_SORTING; }));
    Cancel(submission_);
    victim_->Kill();
    std::string one;
    const TaskCopy again = BeginInParts(1, one);
    const PointCloud of_one = Receive(again, [&] { TakeReports(); });
    EXPECT_GT(of_one.size(), 100'000u);
    EXPECT_EQ(of_two.points_mm, of_one.points_mm);
    EXPECT_EQ(of_two.source, of_one.source);
  }

  std::unique_ptr<ChildProgram> victim_, other_;
  std::string victim_name_, submission_;
  PartReports reports_;
};

// In its third part or a later one: the next one was given ahead, and it has the models.
TEST_F(DisturbedDiscretizerTest, KilledItCostsItsPartAloneAndNoBitOfTheCloud) {
  const PointCloud of_two = CloudOfTwo([&](const PartReports& reports) {
    if (victim_->running() && reports.begun_by_victim.size() >= 3) victim_->Kill();
  });
  EXPECT_FALSE(victim_->running());
  // What it was at, and what lay ready for it.
  EXPECT_GE(reports_.made_again.size(), 1u);
  EXPECT_LE(reports_.made_again.size(), 2u);
  ExpectTheCloudOfOne(of_two);
}

// It comes back while the parts that it had are made by the other: it must not send them.
TEST_F(DisturbedDiscretizerTest, StoppedForAWhileItCostsNoBitOfTheCloud) {
  bool stopped = false, continued = false;
  const PointCloud of_two = CloudOfTwo([&](const PartReports& reports) {
    if (!stopped && reports.begun_by_victim.size() >= 3) {
      victim_->Signal(SIGSTOP);
      stopped = true;
    }
    if (stopped && !continued && !reports.made_again.empty()) {
      victim_->Signal(SIGCONT);
      continued = true;
    }
  });
  EXPECT_TRUE(continued);
  ExpectTheCloudOfOne(of_two);
}

}  // namespace
}  // namespace intaglio::job_service
