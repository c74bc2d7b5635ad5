#include "services/job_service/queue/worker_book.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

class WorkerBookTest : public testing::Test {
 protected:
  void Update(const std::string& instance, intaglio_HealthState state,
              intaglio_ServiceRole role = intaglio_ROLE_DISCRETIZER,
              const std::string& cell = "") {
    book_.Update({instance, role, state, cell, ""}, now_);
  }
  void UpdateOfVersion(const std::string& instance, intaglio_ServiceRole role,
                       const std::string& version) {
    book_.Update({instance, role, intaglio_HEALTH_READY, "c", "", version}, now_);
  }
  std::vector<std::string> Free() { return book_.Free(intaglio_ROLE_DISCRETIZER, "c"); }
  std::vector<std::string> WithoutNext() {
    return book_.WithoutNext(intaglio_ROLE_DISCRETIZER, "j1", 1);
  }

  const TaskId first_{"j1", 1, 0, 0}, second_{"j1", 1, 1, 0};
  Nanoseconds now_{100s};
  WorkerBook book_;
};

TEST_F(WorkerBookTest, OnlyAReadyOneWithoutATaskIsFree) {
  EXPECT_THAT(Free(), IsEmpty());
  Update("b", intaglio_HEALTH_READY);
  Update("a", intaglio_HEALTH_READY);
  Update("busy", intaglio_HEALTH_BUSY);
  EXPECT_THAT(Free(), ElementsAre("a", "b")) << "by name";
  book_.Assign("a", first_, now_);
  EXPECT_THAT(Free(), ElementsAre("b"));
  book_.Release("a", first_, now_);
  EXPECT_THAT(Free(), ElementsAre("a", "b"));
}

TEST_F(WorkerBookTest, ASynchronizerServesItsCellAlone) {
  Update("y", intaglio_HEALTH_READY, intaglio_ROLE_SYNCHRONIZER, "c");
  EXPECT_THAT(book_.Free(intaglio_ROLE_SYNCHRONIZER, "c"), ElementsAre("y"));
  EXPECT_THAT(book_.Free(intaglio_ROLE_SYNCHRONIZER, "another"), IsEmpty());
  EXPECT_EQ(book_.WhyNone(intaglio_ROLE_SYNCHRONIZER, "another", "marker", true),
            "a marker of another (none runs)");
}

TEST_F(WorkerBookTest, OneOfAnotherVersionGetsNothing) {
  UpdateOfVersion("old", intaglio_ROLE_DISCRETIZER, "0.0.9");
  EXPECT_THAT(Free(), IsEmpty());
  EXPECT_EQ(
      book_.WhyNone(intaglio_ROLE_DISCRETIZER, "c", "", true),
      fmt::format("a discretizer (old has version 0.0.9, the job service {}: restart "
                  "the older one when no job is engraved)",
                  host::WireVersion()));
  Update("new", intaglio_HEALTH_BUSY);
  EXPECT_EQ(book_.WhyNone(intaglio_ROLE_DISCRETIZER, "c", "", true),
            "a discretizer (all are busy)");
  Update("new", intaglio_HEALTH_READY);
  EXPECT_THAT(Free(), ElementsAre("new"));
}

TEST_F(WorkerBookTest, ABridgeOfAnotherVersionKeepsItsMachineFromEngraving) {
  Update("y", intaglio_HEALTH_READY, intaglio_ROLE_SYNCHRONIZER, "c");
  Update("y2", intaglio_HEALTH_READY, intaglio_ROLE_SYNCHRONIZER, "c2");
  UpdateOfVersion("b", intaglio_ROLE_MOTION_BRIDGE, "0.0.9");
  EXPECT_THAT(book_.Free(intaglio_ROLE_SYNCHRONIZER, "c"), IsEmpty());
  EXPECT_THAT(book_.WhyNone(intaglio_ROLE_SYNCHRONIZER, "c", "synchronizer", true),
              StartsWith("a synchronizer of c (b has version 0.0.9, "));
  EXPECT_THAT(book_.Free(intaglio_ROLE_SYNCHRONIZER, "c2"), ElementsAre("y2"));
  book_.Lose("b", now_);
  EXPECT_THAT(book_.Free(intaglio_ROLE_SYNCHRONIZER, "c"), ElementsAre("y"));
}

// What it makes it makes to its end, and nothing more.
TEST_F(WorkerBookTest, OneOfAnotherVersionKeepsItsTaskAndGetsNoNext) {
  UpdateOfVersion("old", intaglio_ROLE_DISCRETIZER, "0.0.9");
  book_.Assign("old", first_, now_);
  book_.Answered("old", first_);
  EXPECT_TRUE(book_.IsAssigned("old", first_));
  EXPECT_THAT(WithoutNext(), IsEmpty());
}

// A task to a worker that still drops an older one could be lost.
TEST_F(WorkerBookTest, ARevokedOneIsFreeWhenItIsReadyASecondLater) {
  Update("a", intaglio_HEALTH_READY);
  book_.Assign("a", first_, now_);
  book_.Revoke("a", first_, now_);
  EXPECT_FALSE(book_.IsAssigned("a", first_));
  now_ += 999ms;
  Update("a", intaglio_HEALTH_READY);
  EXPECT_THAT(Free(), IsEmpty());
  now_ += 1ms;
  Update("a", intaglio_HEALTH_BUSY);
  EXPECT_THAT(Free(), IsEmpty());
  Update("a", intaglio_HEALTH_READY);
  EXPECT_THAT(Free(), ElementsAre("a"));
}

TEST_F(WorkerBookTest, TheNextTaskFollowsWhenTheFirstHasEnded) {
  Update("a", intaglio_HEALTH_READY);
  book_.Assign("a", first_, now_);
  EXPECT_THAT(WithoutNext(), IsEmpty()) << "it has not answered yet";
  book_.Answered("a", first_);
  EXPECT_THAT(WithoutNext(), ElementsAre("a"));
  book_.AssignNext("a", second_, now_);
  EXPECT_THAT(WithoutNext(), IsEmpty());
  EXPECT_TRUE(book_.IsAssigned("a", first_));
  EXPECT_TRUE(book_.IsAssigned("a", second_));
  book_.Release("a", first_, now_);
  EXPECT_FALSE(book_.IsAssigned("a", first_));
  EXPECT_TRUE(book_.IsAssigned("a", second_));
  EXPECT_THAT(Free(), IsEmpty());
}

TEST_F(WorkerBookTest, ALostOneIsNotFreeAndReportsWhatItHad) {
  Update("a", intaglio_HEALTH_READY);
  book_.Assign("a", first_, now_);
  book_.AssignNext("a", second_, now_);
  const auto had = book_.Lose("a", now_);
  EXPECT_EQ(had.task.task, first_);
  EXPECT_EQ(had.next.task, second_);
  EXPECT_FALSE(book_.IsAlive("a"));
  EXPECT_TRUE(book_.Lose("unknown", now_).task.empty());
}

TEST_F(WorkerBookTest, SilentIsWhoDoesNotAnswerOrGivesNoHealth) {
  Update("a", intaglio_HEALTH_READY);
  Update("b", intaglio_HEALTH_READY);
  book_.Assign("a", first_, now_);
  book_.Assign("b", second_, now_);
  book_.Answered("b", second_);
  now_ += 10s;
  Update("a", intaglio_HEALTH_READY);
  Update("b", intaglio_HEALTH_BUSY);
  const auto silent = book_.Silent(now_, 10s);
  ASSERT_EQ(silent.size(), 1u);
  EXPECT_EQ(silent[0].first, "a");
  now_ += 10s;
  EXPECT_EQ(book_.Silent(now_, 10s).size(), 2u) << "b gives no health any more";
}

TEST_F(WorkerBookTest, ALostOneIsForgottenWhenManyWereLostAfterIt) {
  for (std::size_t i = 0; i <= WorkerBook::kLostKept; ++i) {
    const std::string name = "d" + std::to_string(100 + i);
    Update(name, intaglio_HEALTH_READY);
    book_.Lose(name, now_);
  }
  EXPECT_THAT(book_.ForgetLost(now_), IsEmpty());
  now_ += WorkerBook::kLostStaysFor;
  EXPECT_THAT(book_.ForgetLost(now_), ElementsAre("d100"));
  EXPECT_EQ(book_.count(), WorkerBook::kLostKept);
}

}  // namespace
}  // namespace intaglio::job_service
