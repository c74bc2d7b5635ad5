// Two job services on one server: one has the queue, the other stands by; the one that
// has it is killed again and again in the middle of a job.

#include <gmock/gmock.h>

#include <array>
#include <cstdlib>
#include <optional>

#include "services/sql/address.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/services/sql/engines.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

class Standby : public test::OnServer<> {
 protected:
  void SetUp() override {
    OnServer::SetUp();
    if (!IsReady()) return;
    Start(services_[0]);
    ASSERT_TRUE(IsServed());
    Start(services_[1]);
  }
  void Start(std::optional<ServiceProcess>& service) {
    service.emplace(folder_, test::PrivateTag(), server_->address(),
                    std::vector<std::string>{"--standby"});
  }
  bool IsServed() {
    return shop_.Until(
        [&] { return shop_.JobServiceHealth().state == intaglio_HEALTH_READY; });
  }
  StatusCopy Job() { return shop_.Status("one"); }
  void RunToEngraving() {
    ASSERT_TRUE(IsServed());
    shop_.Submit("one", GoodJob());
    shop_.Health(intaglio_STAGE_DISCRETIZE, "d", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
    for (const auto stage : {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT})
      Report(stage, intaglio_TASK_DONE, 100);
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0);
    ASSERT_TRUE(shop_.Until([&] { return Job().state == intaglio_JOB_WAITING_FOR_ARM; }));
    shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
    ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 10);
    ASSERT_TRUE(shop_.Until([&] { return Job().state == intaglio_JOB_ENGRAVING; }));
  }
  void Report(intaglio_Stage stage, intaglio_TaskState state, std::uint64_t done) {
    ASSERT_TRUE(shop_.Until([&] { return shop_.Task(stage).attempt == 1; }));
    shop_.Report(shop_.Task(stage), stage, state, done, 100);
  }
  /// Kills the one that has the queue: the permission ends, and comes back from the
  /// other one. How long that took.
  std::chrono::milliseconds KillTheOwner() {
    const auto begin = Clock::now();
    services_[owner_]->Kill();
    EXPECT_TRUE(shop_.Until([&] { return !shop_.granted(); }));
    for (int i = 0; i < 2 && !shop_.granted(); ++i)
      (void)shop_.Until([&] { return shop_.granted(); });
    EXPECT_TRUE(shop_.granted()) << Job().message;
    const auto taken = Clock::now() - begin;
    Start(services_[owner_]);
    owner_ = 1 - owner_;
    return std::chrono::duration_cast<std::chrono::milliseconds>(taken);
  }

  std::filesystem::path folder_ = test::FreshFolder();
  FakeShop shop_{test::PrivateBusOptions()};
  std::array<std::optional<ServiceProcess>, 2> services_;
  std::size_t owner_ = 0;
};

// An arm survives, because the one that stands by knows for how long there was none; no
// submission is lost, none is taken twice.
TEST_F(Standby, TakesOverWithinTwentySecondsAndTheArmSurvives) {
  RunToEngraving();
  const std::uint64_t disarmed = Job().disarm_count;
  const int kills = std::getenv("INTAGLIO_LONG") != nullptr ? 20 : 4;
  for (int i = 0; i < kills; ++i) {
    const std::string name = "more" + std::to_string(i);
    shop_.Submit(name, GoodJob());
    EXPECT_LT(KillTheOwner(), 20s);
    ASSERT_TRUE(shop_.Until([&] { return !shop_.Status(name).uid.empty(); })) << name;
    EXPECT_EQ(Job().state, intaglio_JOB_ENGRAVING);
    EXPECT_TRUE(Job().armed);
    // Absences are added up: they are forgiven after half a minute without one.
    shop_.Command(Job(), intaglio_COMMAND_ARM, 100 + static_cast<std::uint64_t>(i));
    EXPECT_EQ(shop_.AnswerTo(100 + static_cast<std::uint64_t>(i)),
              static_cast<int>(intaglio_ANSWER_TAKEN));
  }
  EXPECT_EQ(Job().disarm_count, disarmed);
  EXPECT_EQ(shop_.status_count(), static_cast<std::size_t>(kills) + 1);
  EXPECT_EQ(shop_.AnswerTo(1), static_cast<int>(intaglio_ANSWER_TAKEN))
      << "what is delivered again is answered again, as it was";
  const auto store = sql::OpenToRead(server_->address());
  EXPECT_EQ(sql::IntegerOf(*store, "SELECT count(*) FROM commands"), kills + 1)
      << "no command was decided twice";
}

// Two start at once: one has the queue, whichever it is, and none ends.
TEST_F(Standby, TwoThatStartAtOnceBothStay) {
  for (auto& service : services_) service.reset();
  for (auto& service : services_) Start(service);
  ASSERT_TRUE(IsServed());
  const auto end = Clock::now() + 4s;
  while (Clock::now() < end) {
    shop_.Poll();
    for (auto& service : services_) {
      int exit_code = 0;
      ASSERT_FALSE(service->Exited(exit_code)) << exit_code;
    }
  }
}

// A server that restarts is waited for; meanwhile there is no permission.
TEST_F(Standby, AServerThatRestartsIsWaitedFor) {
  RunToEngraving();
  server_->Kill();
  EXPECT_TRUE(shop_.Until([&] { return !shop_.granted(); }));
  server_->Start();
  ASSERT_EQ(server_->error(), "");
  bool granted = false;
  for (int i = 0; i < 3 && !granted; ++i)
    granted = shop_.Until([&] { return shop_.granted(); });
  EXPECT_TRUE(granted) << Job().message << shop_.JobServiceHealth().message;
}

}  // namespace
}  // namespace intaglio::job_service
