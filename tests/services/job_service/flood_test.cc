// The real job service, a job that is engraved, and a process that writes a hundred
// thousand samples of random names on control topics: what the flood costs the job
// service, and how long others wait for it meanwhile.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <iostream>
#include <thread>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/version/wire_version.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

using bus::Borrow;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::uint32_t kSamples = 100'000;

double ResidentMb(int pid) {
  std::ifstream statm(fmt::format("/proc/{}/statm", pid));
  std::size_t size = 0, resident = 0;
  statm >> size >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// A process with the identity of a stage worker, from a thread of its own.
class Flooder {
 public:
  void Commands() {
    Run([this](std::uint32_t i) {
      const std::string sender = fmt::format("flooder-{}", i * 2654435761u);
      intaglio_JobCommand sample{};
      sample.sender = Borrow(sender);
      sample.number = i;
      sample.job_uid = Borrow(uid_);
      sample.kind = i % 2 == 0 ? intaglio_COMMAND_ARM : intaglio_COMMAND_PAUSE;
      sample.operator_name = sample.block_id = sample.cell = Borrow(uid_);
      (void)commands_.Write(sample);
    });
  }
  void Statuses() {
    Run([this](std::uint32_t i) {
      const std::string uid = fmt::format("{}-f100d", i);
      const std::string own = "flooder-" + bus_.participant_name();
      intaglio_TaskStatus sample{};
      sample.job_uid = Borrow(uid);
      sample.stage = intaglio_STAGE_DISCRETIZE;
      sample.worker = Borrow(own);
      sample.part_count = 1;
      sample.state = intaglio_TASK_DONE;
      sample.message = Borrow(empty_);
      (void)tasks_.Write(sample);
    });
  }
  void Healths() {
    Run([this](std::uint32_t i) {
      const std::string own = fmt::format("f{}-{}", i, bus_.participant_name());
      intaglio_ServiceHealth sample{};
      sample.instance = Borrow(own);
      sample.role = intaglio_ROLE_DISCRETIZER;
      sample.state = intaglio_HEALTH_FAULT;
      sample.version = Borrow(version_);
      sample.host = sample.job_uid = sample.message = sample.cell = Borrow(empty_);
      (void)health_.Write(sample);
    });
  }
  void Submissions() {
    Run([this](std::uint32_t i) {
      const std::string uid = fmt::format("flood {}", i);
      const std::vector<std::uint8_t> job(200, 0xff);
      intaglio_JobSubmission sample{};
      sample.submission_uid = Borrow(uid);
      sample.client = Borrow(uid_);
      Borrow(sample.job, job);
      (void)submissions_.Write(sample);
    });
  }
  bool done() const { return done_; }
  bool IsSeen() const {
    return commands_.matched_count() > 0 && submissions_.matched_count() > 0 &&
           tasks_.matched_count() > 0 && health_.matched_count() > 0;
  }

 private:
  void Run(std::function<void(std::uint32_t)> write) {
    done_ = false;
    thread_ = std::jthread([this, write](const std::stop_token& stop) {
      for (std::uint32_t i = 0; i < kSamples && !stop.stop_requested(); ++i) write(i);
      done_ = true;
    });
  }
  bus::Bus bus_{test::PrivateBusOptions()};
  const std::string partition_ = bus::RolePartition(bus::kStageWorkerRole);
  bus::Writer<intaglio_JobCommand> commands_{bus_, bus::kJobCommand};
  bus::Writer<intaglio_JobSubmission> submissions_{bus_, bus::kJobSubmission};
  bus::Writer<intaglio_TaskStatus> tasks_{bus_, bus::kTaskStatus, partition_};
  bus::Writer<intaglio_ServiceHealth> health_{bus_, bus::kServiceHealth, partition_};
  const std::string uid_ = "77-f100d", empty_, version_ = host::WireVersion();
  std::atomic<bool> done_{true};
  std::jthread thread_;
};

class FloodTest : public testing::Test {
 protected:
  FloodTest() : service_(folder_, test::PrivateTag()) {}
  void Report(intaglio_Stage stage, intaglio_TaskState state, std::uint64_t done) {
    shop_.Report(shop_.Task(stage), stage, state, done, 100);
  }
  void RunToEngraving() {
    shop_.Submit("one", GoodJob());
    Signs();
    ASSERT_TRUE(shop_.Until([&] {
      return !shop_.Task(intaglio_STAGE_DISCRETIZE).job_uid.empty() && flooder_.IsSeen();
    }));
    Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
    Report(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100);
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0);
    ASSERT_TRUE(shop_.Until(
        [&] { return shop_.Status("one").state == intaglio_JOB_WAITING_FOR_ARM; }));
    shop_.Command(shop_.Status("one"), intaglio_COMMAND_ARM, 1);
    ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 10);
    before_mb_ = ResidentMb(service_.pid());
  }
  void Signs() {
    shop_.Health(intaglio_STAGE_DISCRETIZE, "d", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
  }
  struct Figures {
    double grown_mb = 0, answer_s = 0, permission_gap_s = 0, took_s = 0;
    int answers = 0;
  };
  /// Commands of an honest client one after the other until the flood is over and has
  /// been dealt with for two seconds.
  Figures Measure() {
    Figures figures;
    const auto start = Clock::now();
    auto last_permission = start, next_sign = start, over = start;
    int permissions = shop_.permissions_seen();
    while (!flooder_.done() || Clock::now() - over < 2s) {
      if (!flooder_.done()) over = Clock::now();
      const std::uint64_t number = ++number_;
      const auto sent = Clock::now();
      shop_.Command(shop_.Status("one"), intaglio_COMMAND_SPEED, number);
      bool answered = false;
      while (!answered && Clock::now() - sent < 20s) {
        const auto now = Clock::now();
        if (now >= next_sign) {
          Signs();
          Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 20);
          next_sign = now + 500ms;
        }
        shop_.Poll();
        if (shop_.permissions_seen() != permissions) {
          permissions = shop_.permissions_seen();
          const std::chrono::duration<double> gap = now - last_permission;
          figures.permission_gap_s = std::max(figures.permission_gap_s, gap.count());
          last_permission = now;
        }
        answered = shop_.answers(number) > 0;
        std::this_thread::sleep_for(1ms);
      }
      if (answered) ++figures.answers;
      const std::chrono::duration<double> answer = Clock::now() - sent;
      figures.answer_s = std::max(figures.answer_s, answer.count());
      std::this_thread::sleep_for(20ms);
    }
    figures.grown_mb = ResidentMb(service_.pid()) - before_mb_;
    figures.took_s = std::chrono::duration<double>(Clock::now() - start).count();
    std::cout << fmt::format(
        "grown by {:.1f} MB, longest answer {:.3f} s of {}, longest gap of permissions "
        "{:.3f} s, {:.1f} s in all\n",
        figures.grown_mb, figures.answer_s, figures.answers, figures.permission_gap_s,
        figures.took_s);
    return figures;
  }
  /// The DDS library keeps 0.7 to 0.9 kB of an instance while its writer lives, and half
  /// as much again is room for another release of it. An answer takes some 0.05 s, and
  /// the rest is for a busy computer: a flood that is dealt with in its order takes 20 s.
  void ExpectBounded(const Figures& figures) {
    EXPECT_LT(figures.grown_mb, 1.4e-3 * kSamples);
    EXPECT_LT(figures.answer_s, 1);
    EXPECT_LT(figures.permission_gap_s, 0.25) << "the synchronizer would stop firing";
    EXPECT_GT(figures.answers, 10);
    EXPECT_EQ(shop_.Status("one").state, intaglio_JOB_ENGRAVING);
  }

  std::filesystem::path folder_ = test::FreshFolder();
  FakeShop shop_{test::PrivateBusOptions()};
  Flooder flooder_;
  ServiceProcess service_;
  std::uint64_t number_ = 100;
  double before_mb_ = 0;
};

TEST_F(FloodTest, OfCommandsOfRandomSenders) {
  ASSERT_NO_FATAL_FAILURE(RunToEngraving());
  flooder_.Commands();
  ExpectBounded(Measure());
}

TEST_F(FloodTest, OfSubmissions) {
  ASSERT_NO_FATAL_FAILURE(RunToEngraving());
  flooder_.Submissions();
  std::this_thread::sleep_for(500ms);
  const auto sent = Clock::now();
  shop_.Submit("two", GoodJob());
  EXPECT_TRUE(shop_.Until([&] {
    Signs();
    return !shop_.Status("two").uid.empty();
  }));
  const std::chrono::duration<double> taken = Clock::now() - sent;
  std::cout << fmt::format("a submission was taken after {:.3f} s\n", taken.count());
  ExpectBounded(Measure());
}

TEST_F(FloodTest, OfStatusesOfRandomJobs) {
  ASSERT_NO_FATAL_FAILURE(RunToEngraving());
  flooder_.Statuses();
  ExpectBounded(Measure());
}

TEST_F(FloodTest, OfHealthOfRandomServices) {
  ASSERT_NO_FATAL_FAILURE(RunToEngraving());
  flooder_.Healths();
  ExpectBounded(Measure());
}

}  // namespace
}  // namespace intaglio::job_service
