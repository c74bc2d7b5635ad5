// How a client knows that it has all jobs of a shop, whose job service the test plays.

#include "services/client/known_jobs.h"

#include <gmock/gmock.h>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;
using ::testing::HasSubstr;

class KnownJobs : public testing::Test {
 protected:
  void JobService(intaglio_HealthState state, const std::string& message = "") {
    const std::string text;
    intaglio_ServiceHealth sample{};
    sample.instance = Borrow(kInstance);
    sample.role = intaglio_ROLE_JOB_SERVICE;
    sample.state = state;
    sample.message = Borrow(message);
    sample.host = sample.cell = sample.job_uid = sample.version = Borrow(text);
    EXPECT_TRUE(health_.Write(sample));
  }
  void Count(std::uint64_t jobs) {
    intaglio_JobCount sample{};
    sample.instance = Borrow(kInstance);
    sample.job_count = jobs;
    EXPECT_TRUE(counts_.Write(sample));
  }
  void Job(const std::string& uid, bool dispose = false) {
    const std::string text;
    intaglio_JobStatus sample{};
    sample.job_uid = sample.submission_uid = Borrow(uid);
    sample.name = sample.message = sample.result_directory = sample.cell = Borrow(text);
    sample.number = static_cast<std::uint32_t>(std::stoul(uid));
    EXPECT_TRUE(dispose ? statuses_.Dispose(sample) : statuses_.Write(sample));
  }
  Status Await() { return PollUntilJobsAreKnown(client_, 20s, 300ms); }

  const std::string kInstance = "job-service-1";
  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_JobStatus> statuses_{bus_, bus::kJobStatus};
  bus::Writer<intaglio_JobCount> counts_{bus_, bus::kJobCount};
  bus::Writer<intaglio_ServiceHealth> health_{bus_, bus::kServiceHealth};
  JobClient client_{bus_};
};

TEST_F(KnownJobs, AJobServiceThatHasNotReadItsQueueIsNoEmptyQueue) {
  JobService(intaglio_HEALTH_STARTING);
  const auto known = Await();
  ASSERT_FALSE(known.has_value());
  EXPECT_EQ(known.error().code, ErrorCode::kLinkLost);
  EXPECT_THAT(known.error().message, HasSubstr("has not read its queue"));
  Count(0);
  EXPECT_TRUE(Await().has_value());
}

TEST_F(KnownJobs, AsManyJobsAsTheJobServiceCountsAreWaitedFor) {
  JobService(intaglio_HEALTH_READY);
  Count(3);
  Job("1-a");
  Job("2-a");
  const auto known = Await();
  ASSERT_FALSE(known.has_value());
  EXPECT_EQ(known.error().code, ErrorCode::kLinkLost);
  EXPECT_THAT(known.error().message, HasSubstr("has 3 jobs, and 2 of them have come"));
  Job("3-a");
  EXPECT_TRUE(Await().has_value());
}

// It stays in the client for whoever follows it, and does not stand for another one.
TEST_F(KnownJobs, AJobThatWasWithdrawnIsNotCounted) {
  JobService(intaglio_HEALTH_READY);
  Count(1);
  Job("1-a");
  ASSERT_TRUE(Await().has_value());
  Count(2);
  Job("1-a", true);
  Job("2-a");
  ASSERT_TRUE(client_.PollUntil(
      [&] { return client_.jobs().contains("2-a") && client_.counted_jobs() == 2U; },
      20s));
  EXPECT_FALSE(Await().has_value());
  Count(1);
  EXPECT_TRUE(Await().has_value());
}

TEST_F(KnownJobs, AFaultOfAJobServiceWithoutAQueueIsReportedAtOnce) {
  JobService(intaglio_HEALTH_FAULT, "its disk is full");
  const auto known = PollUntilJobsAreKnown(client_, 20s, 20s);
  ASSERT_FALSE(known.has_value());
  EXPECT_EQ(known.error().code, ErrorCode::kFault);
  EXPECT_THAT(known.error().message, HasSubstr("its disk is full"));
}

TEST_F(KnownJobs, AJobIsNotFoundOnlyWhenAllAreKnown) {
  JobService(intaglio_HEALTH_READY);
  Job("1-a");
  const auto early = AwaitJob(client_, "1", 20s);
  ASSERT_TRUE(early.has_value()) << "it is there, whatever else comes";
  Count(1);
  const auto missing = AwaitJob(client_, "7", 20s);
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace intaglio::client
