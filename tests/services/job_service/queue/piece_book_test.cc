// Whose block is in the machine: the rule that a program arms no job for another's block.

#include "services/job_service/cells/piece_book.h"

#include <gmock/gmock.h>

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Pieces : public ::testing::Test {
 protected:
  static JobRecord Job(std::uint32_t number, std::uint32_t station = 0,
                       const std::string& block = "50 x 50 x 30") {
    JobRecord job;
    job.number = number;
    job.uid = fmt::format("j{}", number);
    job.cell = "c";
    job.place = {station, block};
    return job;
  }
  static CommandView Arm(intaglio_ArmBasis basis, const std::string& block_id = "") {
    CommandView command;
    command.basis = basis;
    command.block_id = block_id;
    return command;
  }
  bool Counts(const JobRecord& job, intaglio_ArmBasis basis = intaglio_ARM_BY_PROGRAM,
              const std::string& block_id = "") {
    return book_.Check(job, Arm(basis, block_id)).taken();
  }
  void Turn() {
    book_.Turn([this](const std::string& uid) { return open_ == uid; });
  }
  void Set(DoorState state) {
    book_.SetDoor("c", state);
    Turn();
  }
  /// The job is made, with the door closed all the while.
  void Make(const JobRecord& job) {
    open_ = job.uid;
    book_.NoteGranted(job);
    Set(DoorState::kClosed);
    open_.clear();
    Turn();
  }

  RecordingActions actions_;
  PieceBook book_{actions_};
  std::string open_;  // the job that has not ended
};

TEST_F(Pieces, TheFirstJobIsArmedByAProgram) { EXPECT_TRUE(Counts(Job(1))); }

TEST_F(Pieces, TheNextOneOnlyOnceTheMachineWasOpenedAndIsClosed) {
  Make(Job(1));
  const CommandAnswer answer = book_.Check(Job(2), Arm(intaglio_ARM_BY_PROGRAM));
  EXPECT_EQ(answer.code, intaglio_ANSWER_SAME_BLOCK);
  EXPECT_THAT(answer.message, HasSubstr("since job 1 was made"));
  EXPECT_THAT(answer.message, HasSubstr("open the door, change the block and close it"));
  Set(DoorState::kOpen);
  EXPECT_FALSE(Counts(Job(2))) << "it is open";
  Set(DoorState::kUnknown);
  EXPECT_FALSE(Counts(Job(2))) << "it may be open";
  Set(DoorState::kClosed);
  EXPECT_TRUE(Counts(Job(2)));
  Make(Job(2));
  EXPECT_FALSE(Counts(Job(3)));
}

TEST_F(Pieces, WhatIsOpenedWhileThePieceIsInWorkChangesNothing) {
  open_ = "j1";
  book_.NoteGranted(Job(1));
  Set(DoorState::kOpen);
  Set(DoorState::kClosed);
  open_.clear();
  Turn();
  EXPECT_FALSE(Counts(Job(2)));
}

TEST_F(Pieces, ADoorThatIsStillOpenAtTheEndOpens) {
  open_ = "j1";
  book_.NoteGranted(Job(1));
  Set(DoorState::kOpen);
  open_.clear();
  Turn();
  Set(DoorState::kClosed);
  EXPECT_TRUE(Counts(Job(2)));
}

TEST_F(Pieces, SilenceOfTheMachineOpensNothing) {
  Make(Job(1));
  Set(DoorState::kUnknown);
  Set(DoorState::kClosed);
  EXPECT_FALSE(Counts(Job(2)));
}

TEST_F(Pieces, APersonsArmNeedsNoOpening) {
  Make(Job(1));
  EXPECT_TRUE(Counts(Job(2), intaglio_ARM_BY_PERSON));
  EXPECT_TRUE(Counts(Job(2), intaglio_ARM_SAME_BLOCK));
  EXPECT_FALSE(Counts(Job(2), static_cast<intaglio_ArmBasis>(77)));
}

TEST_F(Pieces, ThePieceItselfGoesOn) {
  Make(Job(1));
  EXPECT_TRUE(Counts(Job(1)));
}

TEST_F(Pieces, AnotherStationOfTheLoadingNeedsNoOpening) {
  Make(Job(1, 1));
  EXPECT_FALSE(Counts(Job(2, 1)));
  EXPECT_TRUE(Counts(Job(2, 2)));
  EXPECT_FALSE(Counts(Job(2, 2, "100 x 100 x 30"))) << "another loading";
  Make(Job(2, 2));
  EXPECT_FALSE(Counts(Job(3, 1))) << "its block is still there";
  EXPECT_TRUE(Counts(Job(3, 3)));
  Set(DoorState::kOpen);
  Set(DoorState::kClosed);
  EXPECT_TRUE(Counts(Job(3, 1)));
  Make(Job(3, 1));
  EXPECT_THAT(actions_.pieces.at("c").stations, ElementsAre(1));
}

TEST_F(Pieces, ALoaderNamesABlockThatNoOtherJobHad) {
  EXPECT_FALSE(Counts(Job(1), intaglio_ARM_BY_LOADER)) << "no identity";
  EXPECT_TRUE(Counts(Job(1), intaglio_ARM_BY_LOADER, "A"));
  book_.NoteArmed(Job(1), Arm(intaglio_ARM_BY_LOADER, "A"));
  Make(Job(1));
  EXPECT_FALSE(Counts(Job(2), intaglio_ARM_BY_LOADER, "A"));
  EXPECT_TRUE(Counts(Job(1), intaglio_ARM_BY_LOADER, "A")) << "its own";
  EXPECT_TRUE(Counts(Job(2), intaglio_ARM_BY_LOADER, "B"));
  ASSERT_EQ(actions_.blocks.size(), 1u);
  EXPECT_EQ(actions_.blocks[0].block_id, "A");
}

TEST_F(Pieces, ARestartKnowsThePieceTheOpeningAndTheBlocks) {
  Make(Job(1));
  PieceBook next(actions_);
  next.Restore({actions_.pieces.at("c")}, {{"c", "A", "j1"}});
  next.SetDoor("c", DoorState::kClosed);
  EXPECT_FALSE(next.Check(Job(2), Arm(intaglio_ARM_BY_PROGRAM)).taken());
  EXPECT_FALSE(next.Check(Job(2), Arm(intaglio_ARM_BY_LOADER, "A")).taken());
  Set(DoorState::kOpen);
  PieceBook opened(actions_);
  opened.Restore({actions_.pieces.at("c")}, {});
  EXPECT_FALSE(opened.Check(Job(2), Arm(intaglio_ARM_BY_PROGRAM)).taken())
      << "it is not known whether it is closed";
  opened.SetDoor("c", DoorState::kClosed);
  EXPECT_TRUE(opened.Check(Job(2), Arm(intaglio_ARM_BY_PROGRAM)).taken());
}

// The same through the queue, whatever client arms.
class PiecesOfTheQueue : public JobQueueTest {};

TEST_F(PiecesOfTheQueue, AProgramArmsTheNextJobOnlyAfterAnOpening) {
  ReadyAll();
  Add(1);
  queue_.SetDoor("c", DoorState::kClosed);
  const auto engrave = [this](const std::string& uid) {
    for (const intaglio_Stage stage : {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT}) {
      TaskView task;
      const JobRecord& job = *queue_.Find(uid);
      task.task = job.TaskOf(stage);
      task.stage = stage;
      task.worker = stage == intaglio_STAGE_DISCRETIZE ? job.parts.at(0).worker
                                                       : job.stage(stage).worker;
      task.state = intaglio_TASK_DONE;
      task.done_count = task.total_count = 10;
      Report(task);
    }
    TaskView task;
    const JobRecord& job = *queue_.Find(uid);
    task.task = job.TaskOf(intaglio_STAGE_ENGRAVE);
    task.stage = intaglio_STAGE_ENGRAVE;
    task.worker = job.stage(intaglio_STAGE_ENGRAVE).worker;
    task.state = intaglio_TASK_RUNNING;
    task.total_count = 10;
    Report(task);
    return task;
  };
  const auto arm = [this](const std::string& uid) {
    CommandView command = Order(intaglio_COMMAND_ARM, uid);
    command.basis = intaglio_ARM_BY_PROGRAM;
    return Send(command).code;
  };
  TaskView first = engrave("j1");
  ASSERT_EQ(arm("j1"), intaglio_ANSWER_TAKEN);
  (void)queue_.Permissions(now_);
  first.state = intaglio_TASK_DONE;
  Report(first);
  ReadyAll();
  Add(2);
  engrave("j2");
  EXPECT_TRUE(queue_.Find("j2")->awaits_block);
  EXPECT_EQ(arm("j2"), intaglio_ANSWER_SAME_BLOCK);
  queue_.SetDoor("c", DoorState::kOpen);
  EXPECT_EQ(arm("j2"), intaglio_ANSWER_SAME_BLOCK);
  queue_.SetDoor("c", DoorState::kClosed);
  EXPECT_FALSE(queue_.Find("j2")->awaits_block);
  EXPECT_EQ(arm("j2"), intaglio_ANSWER_TAKEN);
}

}  // namespace
}  // namespace intaglio::job_service
