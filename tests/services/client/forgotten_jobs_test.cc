// What a client makes of jobs whose status is withdrawn.

#include <gmock/gmock.h>

#include "services/client/job_client.h"
#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;

class ForgottenJobs : public testing::Test {
 protected:
  void Status(const std::string& uid, intaglio_JobState state, bool dispose = false) {
    const std::string text;
    intaglio_JobStatus sample{};
    sample.job_uid = Borrow(uid);
    sample.submission_uid = Borrow(uid);
    sample.state = state;
    sample.name = sample.message = sample.result_directory = sample.cell = Borrow(text);
    EXPECT_TRUE(dispose ? statuses_.Dispose(sample) : statuses_.Write(sample));
  }
  void Withdraw(const std::string& uid) { Status(uid, intaglio_JOB_QUEUED, true); }
  void JobServiceIsThere(bool there) {
    const std::string instance = "job-service-1", text;
    intaglio_ServiceHealth sample{};
    sample.instance = Borrow(instance);
    sample.role = intaglio_ROLE_JOB_SERVICE;
    sample.host = sample.cell = sample.job_uid = sample.version = sample.message =
        Borrow(text);
    EXPECT_TRUE(there ? health_.Write(sample) : health_.Dispose(sample));
    EXPECT_TRUE(
        client_.PollUntil([&] { return client_.services().empty() != there; }, 10s));
  }
  bool Sees(const std::string& uid, intaglio_JobState state) {
    return client_.PollUntil(
        [&] {
          const auto job = client_.jobs().find(uid);
          return job != client_.jobs().end() && job->second.state == state;
        },
        10s);
  }
  /// What was written before is read by then.
  void Settle() {
    Status("mark" + std::to_string(++marks_), intaglio_JOB_QUEUED);
    EXPECT_TRUE(Sees("mark" + std::to_string(marks_), intaglio_JOB_QUEUED));
  }
  void After(std::chrono::seconds time) {
    now_ += time;
    client_.Poll(0ms);
  }

  JobClient::Clock::time_point now_{1h};
  int marks_ = 0;
  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_JobStatus> statuses_{bus_, bus::kJobStatus};
  bus::Writer<intaglio_ServiceHealth> health_{bus_, bus::kServiceHealth};
  JobClient client_{bus_, [this] { return now_; }};
};

// Both wait unread when the client polls: the end comes first.
TEST_F(ForgottenJobs, AnEndIsReadThoughItIsWithdrawnAlready) {
  Status("1-a", intaglio_JOB_DONE);
  Withdraw("1-a");
  Settle();
  ASSERT_TRUE(client_.jobs().contains("1-a"));
  EXPECT_EQ(client_.jobs().at("1-a").state, intaglio_JOB_DONE);
  EXPECT_FALSE(client_.IsForgotten("1-a")) << "its end is known";
  After(60s);
  EXPECT_TRUE(client_.jobs().contains("1-a")) << "whoever follows it has time";
  After(1s);
  EXPECT_FALSE(client_.jobs().contains("1-a"));
}

TEST_F(ForgottenJobs, AnOpenJobIsForgottenWhenALivingJobServiceDoesNotPublishIt) {
  JobServiceIsThere(true);
  Status("1-a", intaglio_JOB_ENGRAVING);
  ASSERT_TRUE(Sees("1-a", intaglio_JOB_ENGRAVING));
  Withdraw("1-a");
  Settle();
  EXPECT_FALSE(client_.IsForgotten("1-a")) << "it may come back";
  After(10s);
  EXPECT_FALSE(client_.IsForgotten("1-a"));
  After(1s);
  EXPECT_TRUE(client_.IsForgotten("1-a"));
  EXPECT_TRUE(client_.jobs().contains("1-a"));
}

// As when the job service is restarted: all of its jobs lose their writer.
TEST_F(ForgottenJobs, AJobWithoutAJobServiceIsNotForgotten) {
  Status("1-a", intaglio_JOB_ENGRAVING);
  ASSERT_TRUE(Sees("1-a", intaglio_JOB_ENGRAVING));
  Withdraw("1-a");
  Settle();
  After(1h);
  JobServiceIsThere(true);
  EXPECT_FALSE(client_.IsForgotten("1-a"));
  After(9s);
  Status("1-a", intaglio_JOB_PAUSED);
  ASSERT_TRUE(Sees("1-a", intaglio_JOB_PAUSED));
  After(1h);
  EXPECT_FALSE(client_.IsForgotten("1-a"));
}

}  // namespace
}  // namespace intaglio::client
