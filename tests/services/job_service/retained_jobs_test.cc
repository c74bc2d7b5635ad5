// What stays of ended jobs on the bus, and for how long, by a clock of the test's own.

#include <gmock/gmock.h>

#include <map>

#include "services/bus/samples.h"
#include "services/job_service/job_service.h"
#include "tests/proto/test_job.h"
#include "tests/services/bus/private_bus.h"
#include "tests/services/job_service/past_jobs.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using bus::Borrow;
using bus::View;

constexpr auto kRemembered = static_cast<std::uint32_t>(kRememberedJobs);

/// Whoever watches the jobs: what is on the bus, by submission.
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
    AddPastJobs(folder / "jobs.db", kRemembered + 5, 10);
    service_.emplace(
        host_,
        JobServiceOptions{
            folder / "jobs.db", folder / "materials.db", folder / "results", {}},
        now_);
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
  static std::string Past(std::uint32_t number) { return "s" + std::to_string(number); }

  Nanoseconds now_{1000s};
  host::ServiceHost host_{{intaglio_ROLE_JOB_SERVICE, "job-service", "", {}},
                          test::PrivateBusOptions()};
  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_JobSubmission> submissions_{bus_, bus::kJobSubmission};
  bus::Writer<intaglio_JobCommand> commands_{bus_, bus::kJobCommand};
  Watcher watcher_{bus_};
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

}  // namespace
}  // namespace intaglio::job_service
