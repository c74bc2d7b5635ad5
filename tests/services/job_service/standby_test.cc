// Two job services on one server: one has the queue, the other stands by; the one that
// has it is killed again and again in the middle of a job.

#include <gmock/gmock.h>

#include <array>
#include <cstdlib>
#include <optional>
#include <thread>

#include "services/platform/host/safety/absence_limit.h"
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
    if (IsReady()) StartBoth(server_->address());
  }
  void StartBoth(const std::string& address) {
    address_ = address;
    Start(services_[0]);
    ASSERT_TRUE(IsServed());
    Start(services_[1]);
  }
  void Start(std::optional<ServiceProcess>& service) {
    service.emplace(folder_, test::PrivateTag(), address_,
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
    ReportHealth();
    for (const auto stage : {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT})
      Report(stage, intaglio_TASK_DONE, 100);
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0);
    ASSERT_TRUE(shop_.Until([&] { return Job().state == intaglio_JOB_WAITING_FOR_ARM; }));
    shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
    ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 10);
    ASSERT_TRUE(shop_.Until([&] { return Job().state == intaglio_JOB_ENGRAVING; }));
  }
  /// As workers do five times a second; one that does not for ten seconds is lost.
  void ReportHealth() {
    shop_.Health(intaglio_STAGE_DISCRETIZE, "d", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
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
    ExpectTheGrantBack();
    const auto taken = Clock::now() - begin;
    Start(services_[owner_]);
    owner_ = 1 - owner_;
    return std::chrono::duration_cast<std::chrono::milliseconds>(taken);
  }
  void ExpectTheGrantBack() {
    ReportHealth();
    EXPECT_TRUE(shop_.Until([&] { return !shop_.granted(); }));
    for (int i = 0; i < 3 && !shop_.granted(); ++i) {
      (void)shop_.Until([&] { return shop_.granted(); });
      ReportHealth();
    }
    EXPECT_TRUE(shop_.granted()) << Job().message << shop_.JobServiceHealth().message;
  }
  void ArmAnew(std::uint64_t number) {
    shop_.Command(Job(), intaglio_COMMAND_ARM, number);
    EXPECT_EQ(shop_.AnswerTo(number), static_cast<int>(intaglio_ANSWER_TAKEN));
  }
  void WaitUntilAbsencesAreForgiven() {
    const auto end = Clock::now() + host::kMaxAbsence + 1s;
    while (Clock::now() < end) {
      ReportHealth();
      std::this_thread::sleep_for(1s);
      shop_.Poll();
    }
  }
  static int Kills(int few) { return std::getenv("INTAGLIO_LONG") != nullptr ? 20 : few; }

  std::filesystem::path folder_ = test::FreshFolder();
  std::string address_;
  FakeShop shop_{test::PrivateBusOptions()};
  std::array<std::optional<ServiceProcess>, 2> services_;
  std::size_t owner_ = 0;
};

// An arm survives, because the one that stands by knows for how long there was none; no
// submission is lost, none is taken twice.
TEST_F(Standby, TakesOverWithinTwentySecondsAndTheArmSurvives) {
  RunToEngraving();
  const std::uint64_t disarmed = Job().disarm_count;
  const int kills = Kills(4);
  for (int i = 0; i < kills; ++i) {
    const std::string name = "more" + std::to_string(i);
    shop_.Submit(name, GoodJob());
    EXPECT_LT(KillTheOwner(), 20s);
    ASSERT_TRUE(shop_.Until([&] { return !shop_.Status(name).uid.empty(); })) << name;
    EXPECT_EQ(Job().state, intaglio_JOB_ENGRAVING);
    EXPECT_TRUE(Job().armed);
    ArmAnew(100 + static_cast<std::uint64_t>(i));
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
  ExpectTheGrantBack();
}

// A second server follows the first one, and a commit waits for both
// (docs/deployment.md).
class StandbyServer : public Standby {
 protected:
  void SetUp() override {
    OnServer::SetUp();
    if (!IsReady()) return;
    servers_[0] = &*server_;
    servers_[1] = &copy_.emplace(servers_[0]);
    ASSERT_EQ(copy_->error(), "");
    server_->WaitForItsCopy();
    ASSERT_EQ(server_->error(), "");
    StartBoth(server_->AddressWith(*copy_));
  }
  /// Kills the primary; its copy becomes the primary, and it a copy of that one.
  void KillThePrimary() {
    servers_[0]->Kill();
    std::swap(servers_[0], servers_[1]);
    servers_[0]->Promote();
    ASSERT_EQ(servers_[0]->error(), "");
  }
  void MakeTheCopyAnew() {
    servers_[1]->Follow(*servers_[0]);
    ASSERT_EQ(servers_[1]->error(), "");
    servers_[0]->WaitForItsCopy();
    ASSERT_EQ(servers_[0]->error(), "");
  }

  std::optional<test::PostgresServer> copy_;
  std::array<test::PostgresServer*, 2> servers_ = {};
};

// What was acknowledged is on both servers; what was under way comes again from the
// client.
TEST_F(StandbyServer, ThePrimaryIsKilledInMidJobAndNothingIsLostOrTwice) {
  RunToEngraving();
  const std::uint64_t disarmed = Job().disarm_count;
  const int kills = Kills(3);
  for (int i = 0; i < kills; ++i) {
    const std::string known = "known" + std::to_string(i);
    const std::string under_way = "under way" + std::to_string(i);
    shop_.Submit(known, GoodJob());
    ASSERT_TRUE(shop_.Until([&] { return !shop_.Status(known).uid.empty(); })) << known;
    const std::string uid = shop_.Status(known).uid;
    shop_.Submit(under_way, GoodJob());
    ASSERT_NO_FATAL_FAILURE(KillThePrimary());
    ExpectTheGrantBack();
    ASSERT_TRUE(shop_.Until([&] { return !shop_.Status(under_way).uid.empty(); }));
    EXPECT_EQ(shop_.Status(known).uid, uid);
    EXPECT_EQ(Job().state, intaglio_JOB_ENGRAVING);
    EXPECT_TRUE(Job().armed);
    ArmAnew(100 + static_cast<std::uint64_t>(i));
    ASSERT_NO_FATAL_FAILURE(MakeTheCopyAnew());
    // Absences of some two seconds are added up: no arm survives more than 30 s of them.
    if (i % 7 == 6) WaitUntilAbsencesAreForgiven();
  }
  EXPECT_EQ(Job().disarm_count, disarmed);
  const auto store = sql::OpenToRead(address_);
  EXPECT_EQ(sql::IntegerOf(*store, "SELECT count(*) FROM jobs"), 2 * kills + 1);
  EXPECT_EQ(sql::IntegerOf(*store, "SELECT count(*) FROM commands"), kills + 1)
      << "no command was decided twice";
}

}  // namespace
}  // namespace intaglio::job_service
