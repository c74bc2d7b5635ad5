// Every fiftieth part is made by a second discretizer: what follows from equal and from
// different checksums.

#include "tests/services/job_service/queue/discretizer_shop.h"

namespace intaglio::job_service {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

using ComparingTest = DiscretizerShop;

TEST_F(ComparingTest, EveryFiftiethPartIsMadeBySomebodyElseToo) {
  Start("d");
  Start("e");
  for (int i = 0; i < 10; ++i) {
    Begin();
    ASSERT_EQ(job().parts.size(), 16u);
    Work();
    LoadPath();
    EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
    EXPECT_FALSE(job().comparison);
    EXPECT_EQ(job().attempt, 1u);
    End();
  }
  EXPECT_THAT(actions_.comparisons, SizeIs(3)) << "of 160 parts";
  EXPECT_THAT(queue_.Remarks(), IsEmpty());
}

TEST_F(ComparingTest, OneAloneIsNotCompared) {
  Start("d");
  for (int i = 0; i < 120; ++i) {
    Begin();
    Work();
    EXPECT_EQ(job().state, intaglio_JOB_SORTING);
    End();
  }
  EXPECT_THAT(actions_.comparisons, IsEmpty());
  // The part is due: the next one is compared as soon as there is somebody.
  Start("e");
  Begin();
  Work();
  EXPECT_THAT(actions_.comparisons, SizeIs(1));
}

TEST_F(ComparingTest, NothingFiresBeforeTheComparisonHasEnded) {
  Start("d");
  Start("e");
  WorkUntilCompared();
  const std::string second = job().comparison->worker;
  ASSERT_NE(second, "") << "it comes before the open parts";
  const std::string first = second == "d" ? "e" : "d";
  while (WorkOnce(first)) {
  }
  for (std::uint32_t part = 0; part < job().parts.size(); ++part) {
    if (job().parts[part].done) continue;
    // The second one is at the comparison last, for the worst case.
    TaskOrder order{second, intaglio_STAGE_DISCRETIZE,
                    job().TaskOf(intaglio_STAGE_DISCRETIZE, part), "s"};
    if (job().parts[part].worker == second) Report(ReportOf(order, intaglio_TASK_DONE));
  }
  while (WorkOnce(first)) {
  }
  actions_.Orders();
  LoadPath();
  EXPECT_THAT(actions_.Orders(), testing::Not(testing::Contains(HasSubstr("stop"))))
      << "it may still ask for the models";
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_THAT(job().message, HasSubstr("is made by another discretizer and compared"));
  EXPECT_TRUE(Send(intaglio_COMMAND_ARM).taken());
  EXPECT_FALSE(Granted());
  TaskOrder order{second, intaglio_STAGE_DISCRETIZE, job().ComparisonTask(), ""};
  Report(ReportOf(order, intaglio_TASK_DONE));
  EXPECT_TRUE(Granted());
  EXPECT_THAT(actions_.Orders(), testing::Contains("stop " + job().uid));
}

TEST_F(ComparingTest, TheThirdDecidesAndTheJobIsMadeWithoutTheWrongOne) {
  for (const char* name : {"d", "e", "f"}) Start(name);
  wrong_ = {"e"};
  for (int i = 0; i < 40 && queue_.Remarks().empty(); ++i) {
    Begin();
    Work();
    if (queue_.Remarks().empty()) End();
  }
  ASSERT_THAT(queue_.Remarks(), ElementsAre(AllOf(HasSubstr("e made part "),
                                                  HasSubstr("other than d and f"),
                                                  HasSubstr("until it is restarted"))));
  Rest();
  EXPECT_EQ(job().attempt, 2u);
  EXPECT_EQ(job().lost_attempts, 0u) << "it is not the job's fault";
  EXPECT_THAT(job().last_loss, HasSubstr("attempt 1 is made anew: e made part "));
  for (int i = 0; i < 20; ++i) {
    Work();
    LoadPath();
    ASSERT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
    for (const PartRecord& part : job().parts) EXPECT_NE(part.worker, "e");
    EXPECT_TRUE(Send(intaglio_COMMAND_ARM).taken());
    EXPECT_TRUE(Granted());
    End();
    Begin();
  }
  // Its process is another one after a restart.
  Kill("e");
  EXPECT_THAT(queue_.Remarks(), IsEmpty());
  Start("e2");
  Start("e");  // it was only cut off
  EXPECT_THAT(queue_.Remarks(), SizeIs(1));
  End();
  Begin();
  Work();
  std::set<std::string> makers;
  for (const PartRecord& part : job().parts) makers.insert(part.worker);
  EXPECT_THAT(makers, ElementsAre("d", "e2", "f"));
}

class DisputeTest : public DiscretizerShop {
 protected:
  /// Both have made a part, one of them wrong, and nobody else is there.
  void Dispute() {
    Start("d");
    Start("e");
    wrong_ = {"d"};
    WorkUntilCompared();
    EXPECT_TRUE(Send(intaglio_COMMAND_ARM).taken());
    Work();
  }
  void ExpectHeld() {
    EXPECT_EQ(job().attempt, 1u);
    EXPECT_FALSE(job().arm.armed());
    EXPECT_FALSE(Granted());
    EXPECT_THAT(job().message, AllOf(HasSubstr("was made differently by"),
                                     HasSubstr("start another discretizer")));
    EXPECT_THAT(job().message, AllOf(HasSubstr("d"), HasSubstr("e")));
    const CommandAnswer answer = Send(intaglio_COMMAND_ARM);
    EXPECT_EQ(answer.code, intaglio_ANSWER_NOT_YET);
    EXPECT_THAT(answer.message, HasSubstr("was made differently by"));
    EXPECT_THAT(queue_.Remarks(), SizeIs(1));
  }
  /// `right` is known, and the job has no part of another one.
  void ExpectDecided(const std::string& right) {
    Work();
    Rest();
    EXPECT_EQ(job().attempt, 2u);
    Work();
    LoadPath();
    EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM) << job().message;
    bool has_right = false;
    for (const PartRecord& part : job().parts) {
      EXPECT_NE(part.worker, "d");
      has_right = has_right || part.worker == right;
    }
    EXPECT_TRUE(has_right) << "it is taken back";
    EXPECT_FALSE(Granted()) << "a person arms it again";
    EXPECT_TRUE(Send(intaglio_COMMAND_ARM).taken());
    EXPECT_TRUE(Granted());
  }
};

TEST_F(DisputeTest, OfTwoBothAreSuspectedAndTheJobIsHeld) {
  Dispute();
  ExpectHeld();
  // Neither is given anything more.
  for (const auto& [name, tasks] : actions_.given) EXPECT_THAT(tasks, IsEmpty()) << name;
}

TEST_F(DisputeTest, AThirdThatComesDecides) {
  Dispute();
  ExpectHeld();
  Start("f");
  ExpectDecided("e");
  EXPECT_THAT(queue_.Remarks(), ElementsAre(HasSubstr("other than ")));
}

TEST_F(DisputeTest, OneThatIsRestartedDecides) {
  Dispute();
  Kill("d");
  Start("d2");
  ExpectDecided("e");
}

TEST_F(DisputeTest, ThreeThatAllDifferAreAllSuspected) {
  Dispute();
  wrong_.insert("f");
  Start("f");
  Work();
  ExpectHeld();
  EXPECT_THAT(job().message, HasSubstr("f"));
  Start("g");
  Work();
  EXPECT_THAT(queue_.Remarks(), SizeIs(2)) << "d and f are wrong";
}

TEST_F(DisputeTest, ACancelledJobLeavesBothSuspected) {
  Dispute();
  End();
  EXPECT_THAT(queue_.Remarks(), ElementsAre(HasSubstr("restart all of them")));
  Begin();
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
  EXPECT_THAT(job().message, HasSubstr("waits for a discretizer (part "));
}

// What a restart of the job service keeps.
TEST_F(DisputeTest, ARestartForgetsNeitherWhoIsSuspectedNorWhoIsWrong) {
  Dispute();
  ASSERT_THAT(actions_.left_out, SizeIs(2));
  const auto remarks_after = [&] {
    RecordingActions actions;
    JobQueue queue(actions);
    queue.RestoreLeftOut(actions_.left_out, now_);
    EXPECT_THAT(queue.Remarks(), IsEmpty()) << "nobody has reported";
    for (const char* name : {"d", "e"}) {
      queue.Receive(
          WorkerView{name, intaglio_ROLE_DISCRETIZER, intaglio_HEALTH_READY, "", ""},
          now_);
    }
    return queue.Remarks();
  };
  EXPECT_THAT(remarks_after(), ElementsAre(HasSubstr("restart all of them")));
  Start("f");
  Work();
  EXPECT_THAT(actions_.left_out,
              ElementsAre(testing::Field(&LeftOut::worker, testing::StrEq("d"))));
  EXPECT_THAT(remarks_after(), ElementsAre(HasSubstr("d made part ")));
}

// A person has mended it without a restart of its process.
TEST_F(ComparingTest, OneThatWasWrongIsGivenTasksAgainWhenItIsAdmitted) {
  for (const char* name : {"d", "e", "f"}) Start(name);
  wrong_ = {"e"};
  for (int i = 0; i < 40 && queue_.Remarks().empty(); ++i) {
    Begin();
    Work();
    if (queue_.Remarks().empty()) End();
  }
  ASSERT_THAT(queue_.Remarks(),
              ElementsAre(HasSubstr("admitted again (intaglio workers admit e)")));
  EXPECT_THAT(queue_.LeftOutNow(), ElementsAre(testing::Key("e")));
  EXPECT_EQ(queue_.Admit("d", "ann", now_).code, intaglio_ANSWER_NOT_LEFT_OUT);
  EXPECT_EQ(queue_.Admit("nobody", "ann", now_).code, intaglio_ANSWER_NOT_LEFT_OUT);
  wrong_.clear();
  EXPECT_TRUE(queue_.Admit("e", "ann", now_).taken());
  EXPECT_THAT(queue_.Remarks(), IsEmpty());
  EXPECT_THAT(actions_.left_out, IsEmpty()) << "also after a restart";
  EXPECT_EQ(actions_.admitted_by, "ann");
  Rest();
  const std::uint32_t attempt = job().attempt;
  Work();
  LoadPath();
  EXPECT_EQ(job().attempt, attempt) << "what the others have made stays";
  End();
  Begin();
  Work();
  std::set<std::string> makers;
  for (const PartRecord& part : job().parts) makers.insert(part.worker);
  EXPECT_THAT(makers, ElementsAre("d", "e", "f"));
  // Its work is compared as before.
  wrong_ = {"e"};
  for (int i = 0; i < 40 && queue_.Remarks().empty(); ++i) {
    Begin();
    Work();
    if (queue_.Remarks().empty()) End();
  }
  EXPECT_THAT(queue_.Remarks(), ElementsAre(HasSubstr("e made part ")));
}

TEST_F(DisputeTest, NobodyIsAdmittedBeforeTheComparisonIsDecided) {
  Dispute();
  const CommandAnswer answer = queue_.Admit("e", "ann", now_);
  EXPECT_EQ(answer.code, intaglio_ANSWER_UNDECIDED);
  EXPECT_THAT(answer.message, HasSubstr("start another discretizer, which decides"));
  ExpectHeld();
}

// Nobody decides any more which of the two was wrong: what they made for other jobs is
// not trusted because one of them is admitted.
TEST_F(DisputeTest, WhatOneMadeThatIsAdmittedIsMadeAnewForOtherJobs) {
  Start("d");
  Start("e");
  wrong_ = {"d"};
  // Up to some parts before the comparison.
  for (int i = 0; i < 2; ++i) {
    Begin();
    Work();
    End();
  }
  queue_.Receive(
      WorkerView{"y2", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "c2", ""},
      now_);
  Ready("s2", intaglio_ROLE_SORTER);
  JobRecord other;
  other.number = 900;
  other.uid = "other";
  other.epoch = 1;
  other.cell = "c2";
  queue_.Add(other);
  queue_.Turn(now_);
  Work();
  for (int i = 0; i < 40 && queue_.Remarks().empty(); ++i) {
    Begin();
    Work();
    if (queue_.Remarks().empty()) End();
  }
  End();
  const JobRecord& held = *queue_.Find("other");
  ASSERT_THAT(held.suspicion, HasSubstr("restart all of them"));
  ASSERT_TRUE(queue_.Admit("e", "ann", now_).taken());
  EXPECT_EQ(held.attempt, 1u);
  EXPECT_EQ(held.state, intaglio_JOB_QUEUED);
  EXPECT_THAT(held.last_loss, HasSubstr("ann has admitted it again"));
  EXPECT_THAT(queue_.Remarks(), SizeIs(1)) << "the other one is still suspected";
}

TEST_F(ComparingTest, ASecondOneThatIsLostIsReplacedOrNotWaitedFor) {
  for (const char* name : {"d", "e", "f"}) Start(name);
  WorkUntilCompared();
  const std::string maker = job().comparison->made.front().worker;
  const std::string second = job().comparison->worker;
  ASSERT_NE(second, "");
  Kill(second);
  Work([&] { return !job().comparison || job().comparison->at_work(); });
  ASSERT_TRUE(job().comparison);
  const std::string third = job().comparison->worker;
  EXPECT_NE(third, second);
  EXPECT_NE(third, maker);
  EXPECT_EQ(job().comparison->part_attempt(), host::kMaxPartAttempts + 1);
  Kill(third);
  EXPECT_FALSE(job().comparison) << "nobody else is there";
  Work();
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
  EXPECT_THAT(queue_.Remarks(), IsEmpty());
}

TEST_F(ComparingTest, AnEngravingWithPartsOfAWrongOneIsPausedAndNamesIt) {
  Start("d");
  Start("e");
  wrong_ = {"d"};
  // On another machine a job is engraved meanwhile, of parts of both.
  queue_.Receive(
      WorkerView{"y2", intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_READY, "c2", ""},
      now_);
  Ready("s2", intaglio_ROLE_SORTER);
  JobRecord other;
  other.number = 900;
  other.uid = "other";
  other.epoch = 1;
  other.cell = "c2";
  queue_.Add(other);
  queue_.Turn(now_);
  Work();
  const JobRecord& engraved = *queue_.Find("other");
  for (const auto stage : {intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
    TaskView report;
    report.task = engraved.TaskOf(stage);
    report.stage = stage;
    report.worker = engraved.stage(stage).worker;
    report.state =
        stage == intaglio_STAGE_SORT ? intaglio_TASK_DONE : intaglio_TASK_RUNNING;
    report.total_count = 100;
    Report(report);
  }
  CommandView arm;
  arm.basis = intaglio_ARM_BY_PERSON;
  arm.sender = "bob";
  arm.number = 1;
  arm.job_uid = "other";
  arm.epoch = 1;
  arm.kind = intaglio_COMMAND_ARM;
  ASSERT_TRUE(queue_.Receive(arm, now_).taken());
  ASSERT_TRUE(Granted());
  Start("f");
  for (int i = 0; i < 40 && queue_.Remarks().empty(); ++i) {
    Begin();
    Work();
    if (queue_.Remarks().empty()) End();
  }
  EXPECT_EQ(engraved.state, intaglio_JOB_PAUSED);
  EXPECT_EQ(engraved.pause_reason, intaglio_PAUSE_FAULT);
  EXPECT_FALSE(engraved.arm.armed());
  EXPECT_THAT(engraved.message, AllOf(HasSubstr("d made part "),
                                      HasSubstr("compare the piece with its model")));
  EXPECT_EQ(engraved.attempt, 1u) << "it may have points in the glass";
  // In its report, and in its verdict.
  ASSERT_THAT(engraved.warnings, SizeIs(1));
  EXPECT_EQ(engraved.warnings[0].code, WarningCode::kUntrustedPoints);
  EXPECT_EQ(engraved.warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(actions_.kept.at("other").warnings, SizeIs(1));
}

TEST_F(ComparingTest, OneThatCannotMakeWhatTwoOthersMadeIsWrong) {
  for (const char* name : {"d", "e", "f"}) Start(name);
  WorkUntilCompared();
  const std::string second = job().comparison->worker;
  TaskOrder order{second, intaglio_STAGE_DISCRETIZE, job().ComparisonTask(), ""};
  TaskView failed = ReportOf(order, intaglio_TASK_FAILED);
  failed.error_code = intaglio_ERROR_OUTSIDE_BLOCK;
  Report(failed);
  actions_.given.erase(second);
  Work([this] { return !queue_.Remarks().empty(); });
  EXPECT_THAT(queue_.Remarks(), ElementsAre(HasSubstr(second + " made part ")));
}

// ---- Slow ones ------------------------------------------------------------------------

TEST_F(ComparingTest, ASlowOneIsNamedAndLeftOutWhileOthersRun) {
  Start("d");
  Start("e");
  seconds_["e"] = 5.5;
  for (int i = 0; i < 5 && queue_.Remarks().empty(); ++i) {
    Begin();
    Work();
    End();
  }
  EXPECT_THAT(queue_.Remarks(),
              ElementsAre(HasSubstr("e takes 6 times as long for a part as the others")));
  actions_.Orders();
  Begin();
  Work();
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
  EXPECT_THAT(actions_.Orders(),
              testing::Not(testing::Contains(testing::StartsWith("e "))));
  End();
  // Alone it makes everything: a shop with one never stops.
  Kill("d");
  Begin();
  Work();
  EXPECT_EQ(job().state, intaglio_JOB_SORTING);
  EXPECT_EQ(job().parts[0].worker, "e");
  End();
  Start("d");
  now_ += kSlowFor;
  seconds_.clear();
  Begin();
  Work();
  EXPECT_THAT(queue_.Remarks(), IsEmpty()) << "it is tried again";
  EXPECT_EQ(job().parts.size(), 16u);
}

TEST_F(ComparingTest, OneThatIsFourTimesAsSlowHelps) {
  Start("d");
  Start("e");
  seconds_["e"] = 4;
  for (int i = 0; i < 10; ++i) {
    Begin();
    Work();
    End();
  }
  EXPECT_THAT(queue_.Remarks(), IsEmpty());
}

TEST(WorkerPace, CountsAsDocumented) {
  WorkerPace pace;
  const auto done = [&](const char* worker, double elapsed_s, std::uint64_t points,
                        const char* job = "j") {
    return pace.NoteDone(worker, {job, 1, 0, 0}, elapsed_s, points);
  };
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(done("fast", 1, 1000));
  EXPECT_FALSE(done("slow", 100, 1000)) << "its first reads the models";
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(done("slow", 20, 20'000)) << "a part with many points";
    EXPECT_FALSE(done("slow", 1, 0)) << "a part without points";
  }
  EXPECT_FALSE(done("slow", 6, 1000));
  EXPECT_FALSE(done("slow", 6, 1000));
  EXPECT_FALSE(done("slow", 5, 1000)) << "five times as long is not more";
  EXPECT_FALSE(done("slow", 6, 1000));
  EXPECT_FALSE(done("slow", 9, 1000));
  const auto slower = done("slow", 7, 1000);
  ASSERT_TRUE(slower);
  EXPECT_DOUBLE_EQ(*slower, 7);
  EXPECT_FALSE(done("slow", 7, 1000)) << "counted anew";

  // With few parts of others, or short ones, there is nothing to be compared with.
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(done("fast", 1, 1000, "few"));
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(done("slow", 50, 1000, "few"));
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(done("fast", 0.01, 1000, "short"));
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(done("slow", 0.49, 1000, "short"));
}

}  // namespace
}  // namespace intaglio::job_service
