// What stays of ended jobs on the bus, and for how long, by a clock of the test's own.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>

#include "proto/task.pb.h"
#include "services/history/job_history.h"
#include "services/job_service/job_service.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/identity_role.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/past_jobs.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using bus::Borrow;
using bus::View;

constexpr auto kRemembered = static_cast<std::uint32_t>(kRememberedJobs);

/// What a client that watches the jobs sees on the bus, by submission.
class Watcher {
 public:
  explicit Watcher(bus::Bus& bus) : reader_(bus, bus::kJobStatus) {}
  void Poll() {
    reader_.TakeAll([this](const intaglio_JobStatus& sample, const bus::SampleOrigin& o) {
      const std::string uid(View(sample.submission_uid));
      if (!o.alive) {
        there_.erase(uid);
      } else {
        there_[uid] = {std::string(View(sample.job_uid)), sample.epoch, sample.state};
      }
    });
  }
  struct Status {
    std::string job_uid;
    std::uint64_t epoch = 0;
    intaglio_JobState state = intaglio_JOB_QUEUED;
  };
  bool Has(const std::string& submission) const { return there_.contains(submission); }
  Status at(const std::string& submission) const { return there_.at(submission); }
  std::size_t count() const { return there_.size(); }

 private:
  bus::Reader<intaglio_JobStatus> reader_;
  std::map<std::string, Status> there_;
};

class RetainedJobs : public testing::Test {
 protected:
  void SetUp() override {
    const fs::path folder = test::FreshFolder();
    database_ = folder / "jobs.db";
    AddPastJobs(database_, kRemembered + 5, 10);
    // The first was cancelled, and its synchronizer has not answered yet.
    SQLite::Database(database_.string(), SQLite::OPEN_READWRITE)
        .exec(fmt::format(
            "UPDATE tasks SET ended_utc = NULL, outcome = NULL, worker = '{}' "
            "WHERE job_uid = '1-abc' AND stage = {}; "
            "UPDATE jobs SET state = {}, verdict = 'none', "
            "result_directory = '{}' WHERE number = 1",
            Synchronizer(), static_cast<int>(intaglio_STAGE_ENGRAVE),
            static_cast<int>(intaglio_JOB_CANCELLED), (folder / "1-abc").string()));
    // The last one was cancelled, and neither it nor the job service has answered since.
    SQLite::Database(database_.string(), SQLite::OPEN_READWRITE)
        .exec(fmt::format(
            "UPDATE tasks SET ended_utc = NULL, outcome = NULL "
            "WHERE job_uid = '{0}-abc' AND stage = {1}; "
            "UPDATE jobs SET state = {2}, verdict = '', planned_count = 100, "
            "made_count = 40, missed_count = 0, skipped_count = 60, uncertain_count = 0 "
            "WHERE number = {0}",
            kRemembered + 5, static_cast<int>(intaglio_STAGE_ENGRAVE),
            static_cast<int>(intaglio_JOB_CANCELLED)));
    service_.emplace(host_,
                     JobServiceOptions{.database = folder / "jobs.db",
                                       .materials = folder / "materials.db",
                                       .results = folder / "results",
                                       .recording = {}},
                     JobStore(folder / "jobs.db"), std::nullopt, board_, now_);
  }
  bool Until(Watcher& watcher, const std::function<bool()>& condition) {
    return test::Eventually([&] {
      service_->Turn(now_);
      watcher.Poll();
      return condition();
    });
  }
  void Submit(const std::string& uid, const JobSpec& job) {
    const std::string text = job.SerializeAsString(), client = "ann@shop";
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    intaglio_JobSubmission sample{};
    sample.submission_uid = Borrow(uid);
    sample.client = Borrow(client);
    Borrow(sample.job, bytes);
    ASSERT_TRUE(submissions_.Write(sample));
  }
  void Cancel(const Watcher::Status& job) {
    const std::string name = "ann@shop";
    intaglio_JobCommand sample{};
    sample.job_uid = Borrow(job.job_uid);
    sample.epoch = job.epoch;
    sample.number = 1;
    sample.kind = intaglio_COMMAND_CANCEL;
    sample.operator_name = Borrow(name);
    ASSERT_TRUE(commands_.Write(sample));
  }
  /// A worker's name proves which process it is
  /// (services/platform/host/peers/identity_role.h).
  std::string Synchronizer() const {
    return host::InstanceName("synchronizer", "host", 1234, bus_.participant_name());
  }
  static std::string Past(std::uint32_t number) { return "s" + std::to_string(number); }

  fs::path database_;
  Nanoseconds now_{1000s};
  host::ServiceHost host_{{intaglio_ROLE_JOB_SERVICE, "job-service", "", {}},
                          test::PrivateBusOptions()};
  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_JobSubmission> submissions_{bus_, bus::kJobSubmission};
  bus::Writer<intaglio_JobCommand> commands_{bus_, bus::kJobCommand};
  Watcher watcher_{bus_};
  StatusBoard board_{host_.bus(), host_.instance()};
  std::optional<JobService> service_;
};

TEST_F(RetainedJobs, AnEndIsWithdrawnWhenItIsOldAndOthersEndedAfterIt) {
  ASSERT_TRUE(Until(watcher_, [&] { return watcher_.count() == kRemembered; }));
  EXPECT_FALSE(watcher_.Has(Past(5)));
  ASSERT_TRUE(watcher_.Has(Past(6)));
  Submit("new", GoodJob());
  ASSERT_TRUE(Until(watcher_, [&] { return watcher_.Has("new"); }));
  Cancel(watcher_.at("new"));
  ASSERT_TRUE(Until(watcher_,
                    [&] { return watcher_.at("new").state == intaglio_JOB_CANCELLED; }));
  EXPECT_EQ(watcher_.count(), kRemembered + 1);
  now_ += kRememberedFor - 1ns;
  service_->Turn(now_);
  EXPECT_EQ(watcher_.count(), kRemembered + 1);
  now_ += 1ns;
  ASSERT_TRUE(Until(watcher_, [&] { return watcher_.count() == kRemembered; }));
  EXPECT_FALSE(watcher_.Has(Past(6)));
  EXPECT_EQ(watcher_.at("new").state, intaglio_JOB_CANCELLED);
  // A late one sees the same, and no more.
  bus::Bus late_bus(test::PrivateBusOptions());
  Watcher late(late_bus);
  ASSERT_TRUE(
      Until(late, [&] { return late.Has("new") && late.count() == kRemembered; }));
  EXPECT_FALSE(late.Has(Past(6)));
}

TEST_F(RetainedJobs, ARefusalIsWithdrawnWhenItWasRead) {
  Submit("wrong", JobSpec());
  ASSERT_TRUE(Until(watcher_, [&] {
    return watcher_.Has("wrong") && watcher_.count() == kRemembered + 1;
  }));
  EXPECT_EQ(watcher_.at("wrong").state, intaglio_JOB_FAILED);
  now_ += kRememberedFor;
  ASSERT_TRUE(Until(watcher_, [&] { return !watcher_.Has("wrong"); }));
  EXPECT_EQ(watcher_.count(), kRemembered);
}

// Its job has left the memory long ago.
TEST_F(RetainedJobs, WhatALateSynchronizerReportsReachesTheHistory) {
  history::Filter first;
  first.job = 1;
  ASSERT_EQ(history::ReadHistory(database_, first)->at(0).verdict(), "none");
  StageOutcome outcome;
  outcome.mutable_engrave()->set_planned_count(100);
  outcome.mutable_engrave()->set_made_count(40);
  outcome.mutable_engrave()->set_skipped_count(60);
  const std::string text = outcome.SerializeAsString(), uid = "1-abc",
                    worker = Synchronizer(), none;
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  intaglio_TaskStatus late{};
  late.job_uid = Borrow(uid);
  late.stage = intaglio_STAGE_ENGRAVE;
  late.worker = Borrow(worker);
  late.part_count = late.attempt = 1;
  late.state = intaglio_TASK_FAILED;
  late.error_code = intaglio_ERROR_CANCELLED;
  late.message = Borrow(none);
  Borrow(late.outcome, bytes);
  bus::Writer<intaglio_TaskStatus> synchronizer(
      bus_, bus::kTaskStatus, bus::RolePartition(bus::CellRole("els-03")));
  ASSERT_TRUE(synchronizer.Write(late));
  ASSERT_TRUE(Until(watcher_, [&] {
    return history::ReadHistory(database_, first)->at(0).made() == 40;
  }));
  const JobStatistics reported = history::ReadHistory(database_, first)->at(0);
  EXPECT_EQ(reported.verdict(), "not_good");
  EXPECT_EQ(reported.state(), "cancelled");
  EXPECT_FALSE(watcher_.Has(Past(1))) << "nobody has to be told";
}

// By what is known of it: cracks are in the glass.
TEST_F(RetainedJobs, TheEndOfASilentMachineIsSettledInTheEnd) {
  history::Filter last;
  last.job = kRemembered + 5;
  service_->Turn(now_);
  EXPECT_EQ(history::ReadHistory(database_, last)->at(0).verdict(), "");
  now_ += UnsettledEnds::kWithin;
  service_->Turn(now_);
  const JobStatistics settled = history::ReadHistory(database_, last)->at(0);
  EXPECT_EQ(settled.verdict(), "not_good");
  EXPECT_EQ(settled.made(), 40u);
}

TEST_F(RetainedJobs, ASubmissionThatComesAgainIsTheSameJob) {
  Submit("key:order-7:11111111", GoodJob());
  ASSERT_TRUE(Until(watcher_, [&] { return watcher_.Has("key:order-7:11111111"); }));
  const std::string uid = watcher_.at("key:order-7:11111111").job_uid;
  Submit("key:order-7:11111111", GoodJob());
  // Another job under the same key is refused, and another key is another job.
  Submit("key:order-7:22222222", GoodJob());
  Submit("key:order-70:33333333", GoodJob());
  ASSERT_TRUE(Until(watcher_, [&] {
    return watcher_.Has("key:order-7:22222222") && watcher_.Has("key:order-70:33333333");
  }));
  EXPECT_EQ(watcher_.at("key:order-7:11111111").job_uid, uid);
  EXPECT_EQ(watcher_.at("key:order-7:22222222").job_uid, "");
  EXPECT_EQ(watcher_.at("key:order-7:22222222").state, intaglio_JOB_FAILED);
  EXPECT_NE(watcher_.at("key:order-70:33333333").job_uid, "");
  EXPECT_EQ(watcher_.count(), kRemembered + 3);
}

TEST_F(RetainedJobs, ASubmissionOfLongAgoIsAnsweredWithItsJob) {
  ASSERT_TRUE(Until(watcher_, [&] { return watcher_.count() == kRemembered; }));
  ASSERT_FALSE(watcher_.Has(Past(2)));
  Submit(Past(2), GoodJob());
  ASSERT_TRUE(Until(watcher_, [&] { return watcher_.Has(Past(2)); }));
  EXPECT_EQ(watcher_.at(Past(2)).job_uid, "2-abc");
  EXPECT_EQ(watcher_.count(), kRemembered + 1) << "nothing new was made";
  now_ += kRememberedFor;
  ASSERT_TRUE(Until(watcher_, [&] { return !watcher_.Has(Past(2)); }));
}

}  // namespace
}  // namespace intaglio::job_service
