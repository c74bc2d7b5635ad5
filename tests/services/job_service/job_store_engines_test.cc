// What JobStore keeps, in a file and on a server.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <optional>
#include <thread>

#include "services/history/job_history.h"
#include "services/job_service/boot_clock.h"
#include "services/job_service/job_store.h"
#include "services/job_service/store_turn.h"
#include "services/platform/host/stage/task_part.h"
#include "services/platform/host/times/utc_time.h"
#include "services/sql/address.h"
#include "tests/patience.h"
#include "tests/services/job_service/job_store_rig.h"
#include "tests/services/sql/engines.h"

namespace intaglio::job_service {
namespace {

class JobStoreEngine : public test::OnEachEngine<JobStoreRig> {};

TEST_P(JobStoreEngine, KeepsTheFirstAnswerToACommandOfEachSender) {
  CommandView command;
  command.sender = "ann";
  command.number = 3;
  command.job_uid = "1-abc";
  JobStore(address_).KeepAnswer(command, {intaglio_ANSWER_NOT_YET, "it waits"});
  JobStore store(address_);
  store.KeepAnswer(command, {intaglio_ANSWER_TAKEN, ""});
  command.sender = "bob";
  store.KeepAnswer(command, {intaglio_ANSWER_TAKEN, ""});
  ASSERT_TRUE(store.AnswerTo("ann", 3).has_value());
  EXPECT_EQ(store.AnswerTo("ann", 3)->code, intaglio_ANSWER_NOT_YET);
  EXPECT_EQ(store.AnswerTo("ann", 3)->message, "it waits");
  EXPECT_TRUE(store.AnswerTo("bob", 3)->taken());
  EXPECT_FALSE(store.AnswerTo("ann", 4).has_value());
}

TEST_P(JobStoreEngine, KeepsEveryFieldThatHasToLast) {
  const JobRecord kept = Record(1, intaglio_JOB_SORTING);
  JobStore(address_).Keep(kept);
  const auto loaded = JobStore(address_).Load(0);
  ASSERT_EQ(loaded.size(), 1u);
  const JobRecord& job = loaded[0];
  EXPECT_EQ(job.number, kept.number);
  EXPECT_EQ(job.uid, kept.uid);
  EXPECT_EQ(job.submission_uid, kept.submission_uid);
  EXPECT_EQ(job.epoch, kept.epoch);
  EXPECT_EQ(job.name, kept.name);
  EXPECT_EQ(job.cell, kept.cell);
  EXPECT_EQ(job.material, kept.material);
  EXPECT_EQ(job.priority, kept.priority);
  EXPECT_EQ(job.turn, kept.turn);
  EXPECT_EQ(job.rate_hz, kept.rate_hz);
  EXPECT_EQ(job.result_directory, kept.result_directory);
  EXPECT_EQ(job.frozen_job, kept.frozen_job);
  EXPECT_EQ(job.state, kept.state);
  EXPECT_EQ(job.attempt, kept.attempt);
  EXPECT_EQ(job.lost_attempts, kept.lost_attempts);
  EXPECT_EQ(job.message, kept.message);
  EXPECT_EQ(job.estimate_ticks, kept.estimate_ticks);
  EXPECT_EQ(job.first_estimate_ticks, kept.first_estimate_ticks);
  const KeptArm& arm = job.arm.kept();
  EXPECT_EQ(arm.last_command, kept.arm.kept().last_command);
  EXPECT_TRUE(arm.ever_granted);
  EXPECT_EQ(arm.first_point, kept.arm.kept().first_point);
  EXPECT_TRUE(arm.fire_uncertain);
  EXPECT_EQ(arm.disarm_count, kept.arm.kept().disarm_count);
  EXPECT_EQ(arm.disarm_reason, kept.arm.kept().disarm_reason);
  EXPECT_EQ(arm.last_command_id, kept.arm.kept().last_command_id);
  EXPECT_EQ(job.pause_reason, kept.pause_reason);
  EXPECT_FALSE(arm.armed);
  EXPECT_GT(job.revision, kept.revision)
      << "what was published since the last Keep is older";
  const StageRecord& stage = job.stage(intaglio_STAGE_SORT);
  EXPECT_EQ(stage.worker, "sorter-1");
  EXPECT_TRUE(stage.done);
  EXPECT_EQ(stage.done_count, 7u);
  EXPECT_EQ(stage.total_count, 8u);
  EXPECT_EQ(stage.elapsed_s, 1.5);
}

TEST_P(JobStoreEngine, ALaterKeepReplacesTheEarlier) {
  JobStore store(address_);
  JobRecord job = Record(1, intaglio_JOB_SORTING);
  store.Keep(job);
  job.state = intaglio_JOB_ENGRAVING;
  job.message = "";
  store.Keep(job);
  ASSERT_EQ(store.Load(0).size(), 1u);
  EXPECT_EQ(store.Load(0)[0].state, intaglio_JOB_ENGRAVING);
  EXPECT_EQ(store.Load(0)[0].message, "");
}

TEST_P(JobStoreEngine, LoadsOpenJobsAndTheNewestEndedOnes) {
  JobStore store(address_);
  for (std::uint32_t n = 1; n <= 6; ++n) {
    store.Keep(Record(n, n == 2 ? intaglio_JOB_QUEUED : intaglio_JOB_DONE));
  }
  std::vector<std::uint32_t> numbers;
  for (const JobRecord& job : store.Load(2)) numbers.push_back(job.number);
  EXPECT_THAT(numbers, testing::ElementsAre(2, 5, 6));
  EXPECT_EQ(store.NextNumber(), 7u);
}

TEST_P(JobStoreEngine, EndedJobsAreLoadedWithoutTheirFrozenJobs) {
  JobStore store(address_);
  store.Keep(Record(1, intaglio_JOB_QUEUED));
  store.Keep(Record(2, intaglio_JOB_DONE));
  const auto jobs = store.Load(10);
  ASSERT_EQ(jobs.size(), 2u);
  EXPECT_EQ(jobs[0].frozen_job.size(), 4u);
  EXPECT_EQ(jobs[1].frozen_job.size(), 0u);
  EXPECT_EQ(jobs[1].stage(intaglio_STAGE_SORT).worker, "sorter-1");
}

TEST_P(JobStoreEngine, FindsAnEndedJobThatIsNotInMemory) {
  JobStore store(address_);
  store.Keep(Record(1, intaglio_JOB_PAUSED));
  store.Keep(Record(2, intaglio_JOB_CANCELLED));
  EXPECT_FALSE(store.LoadEnded("1-abc")) << "open";
  EXPECT_FALSE(store.LoadEnded("3-abc"));
  const auto job = store.LoadEnded("2-abc");
  ASSERT_TRUE(job);
  EXPECT_EQ(job->number, 2u);
  EXPECT_EQ(job->state, intaglio_JOB_CANCELLED);
  EXPECT_EQ(job->result_directory, "/results/2-abc");
}

TEST_P(JobStoreEngine, EpochsGrowFromRunToRun) {
  std::uint64_t last = 0;
  for (int i = 0; i < 5; ++i) {
    const std::uint64_t epoch = JobStore(address_).BeginRun();
    EXPECT_GT(epoch, last);
    last = epoch;
  }
}

TEST_P(JobStoreEngine, RemembersSubmissions) {
  {
    JobStore store(address_);
    EXPECT_FALSE(store.OutcomeOf("s1"));
    store.Keep(Record(1, intaglio_JOB_QUEUED));
    EXPECT_EQ(store.OutcomeOf("s1"), "");
    store.KeepRefusal("s2", "glass: is missing");
  }
  EXPECT_EQ(JobStore(address_).OutcomeOf("s2"), "glass: is missing");
}

TEST_P(JobStoreEngine, LoadsThePartsThatAreHandedOut) {
  std::optional<JobStore> opened(address_);
  JobStore& store = *opened;
  store.Keep(Record(1, intaglio_JOB_DISCRETIZING));
  const auto give = [&store](std::uint32_t attempt, std::uint32_t part,
                             std::uint32_t part_attempt, const std::string& worker) {
    TaskOrder order;
    order.worker = worker;
    order.task = {"1-abc", attempt, part, part_attempt};
    store.KeepTask(order);
    return order;
  };
  give(1, 3, 0, "of an older attempt");
  TaskOrder lost = give(2, 0, 0, "lost");
  lost.revoked = true;
  store.KeepTask(lost);
  TaskView done;
  done.task = give(2, 1, 0, "done").task;
  done.worker = "done";
  done.state = intaglio_TASK_DONE;
  store.KeepTaskEnd(done, "");
  give(2, 0, 1, "again");
  give(2, 2, 0, "at work");
  give(2, 2, host::kMaxPartAttempts, "compares it");
  opened.reset();
  const auto parts = JobStore(address_).Load(0).at(0).parts;
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].worker, "again");
  EXPECT_EQ(parts[0].attempt, 1u);
  EXPECT_EQ(parts[1].worker, "");
  EXPECT_EQ(parts[2].worker, "at work");
  EXPECT_EQ(parts[2].attempt, 0u);
}

TEST_P(JobStoreEngine, ReportsWhatBecameOfAJob) {
  JobStore store(address_);
  JobRecord job = Record(1, intaglio_JOB_QUEUED);
  job.attempt = 0;
  job.arm = JobArm();
  const auto now = std::chrono::system_clock::now();
  store.Keep(job);
  JobStatistics statistics = store.StatisticsOf(job, now);
  EXPECT_EQ(statistics.state(), "queued");
  EXPECT_NE(statistics.submitted_utc(), "");
  EXPECT_EQ(statistics.started_utc(), "");
  job.attempt = 2;
  job.arm.NoteGranted();
  job.state = intaglio_JOB_ENGRAVING;
  job.estimate_ticks = 400;
  job.first_estimate_ticks = 460;
  store.Keep(job);
  GiveEngraving(store);
  job.stage(intaglio_STAGE_ENGRAVE) = {"y", false, 25, 100, 1.0};
  const auto later = now + std::chrono::seconds(10);
  statistics = store.StatisticsOf(job, later);
  const std::string begun = statistics.engraving_utc();
  EXPECT_NE(begun, "");
  EXPECT_EQ(statistics.progress_ratio(), 0.25);
  EXPECT_EQ(statistics.made(), 25u);
  EXPECT_EQ(statistics.estimated_s(), 4);
  EXPECT_EQ(statistics.first_estimated_s(), 4.6);
  EXPECT_EQ(statistics.first_estimate_ratio(), 0) << "there is no outcome";
  // A quarter took one second: three are left.
  EXPECT_EQ(statistics.expected_end_utc(),
            host::UtcText(later + std::chrono::seconds(3)));
  EXPECT_EQ(statistics.verdict(), "");
  store.KeepTaskEnd(EngraveEnd(intaglio_TASK_DONE), Outcome(100, 100));
  job.state = intaglio_JOB_DONE;
  store.Keep(job);
  store.KeepVerdict(job.uid, "/r/report.json", "/r/all.mcap");
  statistics = store.StatisticsOf(job, later);
  EXPECT_EQ(statistics.verdict(), "good");
  EXPECT_EQ(statistics.made(), 100u);
  EXPECT_EQ(statistics.machining_s(), 2);
  EXPECT_EQ(statistics.undisturbed_s(), 2);
  EXPECT_EQ(statistics.estimate_ratio(), 2);
  EXPECT_EQ(statistics.first_estimate_ratio(), 2.3);
  EXPECT_EQ(statistics.engraving_utc(), begun) << "the first time stays";
  EXPECT_EQ(statistics.expected_end_utc(), "");
  EXPECT_EQ(statistics.report(), "/r/report.json");
  EXPECT_EQ(statistics.recording(), "/r/all.mcap");
}

// A cancelled job's synchronizer reports afterwards what it left in the glass.
TEST_P(JobStoreEngine, TheLastReportOfTheMachineChangesTheVerdict) {
  JobStore store(address_);
  JobRecord job = Record(1, intaglio_JOB_ENGRAVING);
  store.Keep(job);
  GiveEngraving(store);
  job.state = intaglio_JOB_CANCELLED;
  store.Keep(job);
  store.KeepVerdict(job.uid, "", "");
  const auto now = std::chrono::system_clock::now();
  const JobStatistics before = store.StatisticsOf(job, now);
  EXPECT_EQ(before.verdict(), "none");
  store.KeepTaskEnd(EngraveEnd(intaglio_TASK_FAILED), Outcome(100, 40));
  store.KeepVerdict(job.uid, "", "");
  const JobStatistics after = store.StatisticsOf(job, now);
  EXPECT_EQ(after.verdict(), "not_good");
  EXPECT_EQ(after.made(), 40u);
  const JobResult result = store.ResultOf(job.uid);
  EXPECT_EQ(result.verdict, "not_good");
  EXPECT_EQ(result.counts.planned, 100u);
  EXPECT_EQ(result.counts.made, 40u);
  EXPECT_EQ(store.ResultOf("nobody").verdict, "");
  EXPECT_EQ(after.ended_utc(), before.ended_utc());
}

TEST_P(JobStoreEngine, KeepsWhatIsKnownOfTheMachines) {
  {
    JobStore store(address_);
    PieceRecord piece{"els-03", "1-abc", 1, false, {2, 3}, "b7"};
    store.KeepPiece(piece);
    piece.opened = true;
    store.KeepPiece(piece);
    store.KeepLoadedBlock({"els-03", "b7", "1-abc"});
    store.KeepLoadedBlock({"els-03", "b7", "2-abc"});
    for (const std::uint64_t number : {1u, 2u}) {
      MountRecord mount;
      mount.number = number;
      mount.cell = "els-03";
      mount.parts.block_mm = Vec3(50, 60, 70);
      mount.parts.glass = number == 1 ? "K8" : "N-BK7";
      mount.operator_name = "ann";
      mount.mounted_utc = "2026-11-27T05:00:00.000Z";
      store.KeepMount(mount);
    }
  }
  JobStore store(address_);
  const auto pieces = store.LoadPieces();
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_TRUE(pieces[0].opened);
  EXPECT_THAT(pieces[0].stations, testing::ElementsAre(2, 3));
  const auto blocks = store.LoadLoadedBlocks();
  ASSERT_EQ(blocks.size(), 1u);
  EXPECT_EQ(blocks[0].job_uid, "1-abc") << "a block stays with its first job";
  const auto mounts = store.LoadMounts();
  ASSERT_EQ(mounts.size(), 1u);
  EXPECT_EQ(mounts[0].parts.glass, "N-BK7");
  EXPECT_EQ(mounts[0].parts.block_mm->z(), 70);
}

TEST_P(JobStoreEngine, KeepsWhoIsLeftOut) {
  const LeftOut wrong{"d", "d is wrong", true};
  {
    JobStore store(address_);
    store.KeepLeftOut({"d", "d or e is wrong", false});
    store.KeepLeftOut({"e", "d or e is wrong", false});
    store.KeepLeftOut(wrong);
    store.KeepLeftOut({"e", "", false});
  }
  EXPECT_THAT(JobStore(address_).LoadLeftOut(), testing::ElementsAre(wrong));
}

TEST_P(JobStoreEngine, RecordsWhatBecameOfWorkers) {
  {
    JobStore store(address_);
    store.KeepLeftOut({"d", "d or e is wrong", false});
    store.KeepLeftOut({"d", "d or e is wrong", false});  // nothing has changed
    store.KeepLeftOut({"e", "d or e is wrong", false});
    store.KeepLeftOut({"d", "d is wrong", true});
    store.KeepLeftOut({"e", "", false});
    store.KeepLeftOut({"never", "", false});
    store.KeepLeftOut({"d", "", false, "ann@shop-1"});
  }
  const auto history = history::ReadWorkerHistory(address_);
  ASSERT_TRUE(history) << history.error().message;
  std::vector<std::string> events;
  for (const WorkerEvent& event : history->events()) {
    EXPECT_EQ(event.time_utc().size(), 24u) << event.time_utc();
    events.push_back(fmt::format("{} {} {}{}", event.worker(), event.event(), event.why(),
                                 event.operator_name()));
  }
  EXPECT_THAT(events, testing::ElementsAre(
                          "d suspected d or e is wrong", "e suspected d or e is wrong",
                          "d wrong d is wrong", "e cleared ", "d admitted ann@shop-1"));
}

// A process that floods does not fill the disk, and what was accepted stays.
TEST_P(JobStoreEngine, KeepsTheNewestRefusals) {
  JobStore store(address_);
  store.Limit({.max_count = 50, .stays = std::chrono::seconds(0), .drop_every = 10});
  CommandView command;
  command.job_uid = "1-abc";
  command.sender = "ann";
  store.KeepAnswer(command, {});
  command.sender = "flood";
  for (command.number = 1; command.number <= 200; ++command.number) {
    store.KeepAnswer(command, {intaglio_ANSWER_WRONG_EPOCH, "it is of another run"});
    store.KeepRefusal(fmt::format("flood~{}", command.number), "no job");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the times differ
  }
  int commands = 0, submissions = 0;
  for (std::uint64_t number = 1; number <= 200; ++number) {
    commands += store.AnswerTo("flood", number) ? 1 : 0;
    submissions += store.OutcomeOf(fmt::format("flood~{}", number)) ? 1 : 0;
  }
  EXPECT_GE(commands, 50);
  EXPECT_LE(commands, 60);
  EXPECT_GE(submissions, 50);
  EXPECT_LE(submissions, 60);
  EXPECT_TRUE(store.AnswerTo("flood", 200));
  EXPECT_TRUE(store.AnswerTo("ann", 0)->taken());
  // A client may still wait for these.
  store.Limit({.max_count = 50, .stays = std::chrono::hours(1), .drop_every = 10});
  for (command.number = 201; command.number <= 300; ++command.number)
    store.KeepAnswer(command, {intaglio_ANSWER_WRONG_EPOCH, "it is of another run"});
  for (std::uint64_t number = 201; number <= 300; ++number)
    EXPECT_TRUE(store.AnswerTo("flood", number)) << number;
}

TEST_P(JobStoreEngine, FindsAKeyUnderWhichAJobWasTaken) {
  JobStore store(address_);
  JobRecord job = Record(4, intaglio_JOB_QUEUED);
  job.submission_uid = "key~0123";
  store.Keep(job);
  EXPECT_EQ(store.TakenUnder("key~"), 4u);
  EXPECT_EQ(store.TakenUnder("KEY~"), std::nullopt);
  EXPECT_EQ(store.JobOf("key~0123"), "4-abc");
}

TEST_P(JobStoreEngine, ReadsTheHistoryBesideTheJobService) {
  JobStore store(address_);
  JobRecord job = Record(7, intaglio_JOB_DONE);
  job.name = "Łódź cup";
  store.Keep(job);
  history::Filter filter;
  filter.piece = "CUP";
  const auto found = history::ReadHistory(address_, filter);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->size(), 1u);
  EXPECT_EQ(found->at(0).name(), "Łódź cup");
  filter.piece = "vase";
  EXPECT_TRUE(history::ReadHistory(address_, filter)->empty());
  const auto spec = history::ReadJob(address_, "8");
  ASSERT_FALSE(spec);
  EXPECT_EQ(spec.error().code, ErrorCode::kNotFound);
}

INSTANTIATE_TEST_SUITE_P(Engines, JobStoreEngine, test::EachEngine(), test::NameOfEngine);

class StoreOnServer : public test::OnServer<JobStoreRig> {};

TEST_F(StoreOnServer, ASecondJobServiceIsRefusedOrWaits) {
  auto first = std::make_optional<JobStore>(server_->address());
  try {
    const JobStore second(server_->address());
    FAIL();
  } catch (const StoreError& error) {
    EXPECT_FALSE(error.passes());
    EXPECT_THAT(error.what(), testing::HasSubstr("--standby"));
  }
  StoreTurn turn(server_->address(), true);
  first->Keep(Record(1, intaglio_JOB_QUEUED));
  first->KeepNote("boot 1 1 0\n");
  EXPECT_FALSE(turn.Try());
  EXPECT_FALSE(turn.seen()) << "nobody knows when it was written";
  const auto asked_at = SinceBoot();
  first->KeepNote("boot 2 1 0\n");
  EXPECT_FALSE(turn.Try());
  ASSERT_TRUE(turn.seen());
  EXPECT_EQ(turn.seen()->note, "boot 2 1 0\n");
  EXPECT_LE(turn.seen()->at, asked_at);
  first.reset();
  // A server ends a session a moment after its client.
  std::optional<JobStore> store;
  ASSERT_TRUE(test::Eventually([&] {
    if (auto turned = turn.Try()) store.emplace(std::move(*turned));
    return store.has_value();
  }));
  EXPECT_EQ(store->Load(0).size(), 1u);
}

// Else the time in which it had the queue would be an absence, and cost the arm.
TEST_F(StoreOnServer, WhoHadTheQueueHasSeenNothingOfItsOwnNotes) {
  StoreTurn turn(server_->address(), true);
  {
    auto store = turn.Try();
    ASSERT_TRUE(store);
    store->KeepNote("boot 1 1 0\n");
    server_->EndSessions();
  }
  ASSERT_TRUE(test::Eventually([&] { return turn.Try().has_value(); }));
  EXPECT_FALSE(turn.seen());
}

TEST_F(StoreOnServer, AServerThatEndsTheSessionTakesTheOwnership) {
  JobStore store(server_->address());
  server_->EndSessions();
  try {
    store.KeepNote("boot 1 1 0\n");
    FAIL();
  } catch (const StoreError& error) {
    EXPECT_TRUE(error.passes()) << error.what();
    EXPECT_THAT(error.what(), testing::HasSubstr("its server runs"));
  }
  EXPECT_NO_THROW(JobStore(server_->address()));
}

}  // namespace
}  // namespace intaglio::job_service
