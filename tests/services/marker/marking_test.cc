#include "services/marker/marking.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

#include "engrave/mark/mark_file.h"
#include "services/cell/pause_reason.h"
#include "services/cell/point_counts.h"
#include "services/marker/marking_preparation.h"
#include "tests/services/marker/fake_head.h"

namespace intaglio::marker {
namespace {

namespace fs = std::filesystem;
using cell::PointState;
using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr std::uint32_t kCount = 12;

mark::MarkSet SomeMarks(std::uint32_t count) {
  mark::MarkSet set;
  set.pens.push_back({"p", 100, 0.5, 20000, 1, 0, 0});
  for (std::uint32_t i = 0; i < count; ++i)
    set.marks.push_back({0, false, 0, {{Vec2(i, 0)}, {Vec2(i, 1)}}});
  return set;
}

/// Each arrives when the web has moved a field.
mark::MarkSet MarksOnAWeb(std::uint32_t count) {
  mark::MarkSet set = SomeMarks(count);
  for (std::uint32_t i = 0; i < count; ++i) set.marks[i].web_mm = 50.0 * i;
  return set;
}

class MarkingTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("marking-" + std::to_string(getpid()));
    fs::remove_all(folder_);
    frozen_.set_job_uid("1-a");
    frozen_.set_epoch(7);
    frozen_.set_result_directory(folder_.string());
    inputs_.permission_fresh = inputs_.permission_granted = true;
    inputs_.grant = {1, 0};
    inputs_.now = 100s;
    Begin(SomeMarks(kCount));
  }
  void TearDown() override {
    marking_.reset();
    journal_.reset();
    fs::remove_all(folder_);
  }

  void Begin(std::optional<mark::MarkSet> marks) {
    marking_.reset();
    journal_.reset();
    const bool again = !marks;
    auto prepared = PrepareMarking(frozen_, std::move(marks),
                                   [](std::uint64_t, std::uint64_t) { return true; });
    ASSERT_TRUE(prepared) << prepared.error().message;
    if (again) {
      chain_ = std::make_unique<cell::PermissionChain>();
      chain_->BeginJob();
      chain_->TakeUp(
          {std::max(1u, prepared->job.earlier.power_up), prepared->job.earlier.openings});
    } else {
      // What the marker does between jobs: the machine is watched.
      chain_ = std::make_unique<cell::PermissionChain>();
      chain_->Watch(LinksOf(head_.state(), inputs_), inputs_.now);
      chain_->BeginJob();
    }
    journal_ = prepared->journal;
    marking_ =
        std::make_unique<Marking>(std::move(prepared->job), head_, *journal_, *chain_);
  }
  /// kill -9 of the marker, and another one.
  void Restart() {
    marking_.reset();
    journal_.reset();
    head_.LoseHost();
    Begin(std::nullopt);
  }

  void Turn() {
    inputs_.now += 5ms;
    marking_->Turn(inputs_);
    // The disk has its time: the test's does not pass by the clock.
    for (int i = 0; journal_->durable() != journal_->appended() && i < 2000; ++i)
      std::this_thread::sleep_for(100us);
  }
  /// The controller makes half a mark at each turn.
  bool TurnUntil(const std::function<bool()>& condition, int turns = 3000) {
    for (int i = 0; i < turns && !condition(); ++i) {
      Turn();
      head_.Step();
    }
    return condition();
  }
  bool ToItsEnd() {
    return TurnUntil([&] { return marking_->phase() == Marking::Phase::kDone; });
  }
  bool TillMade(std::size_t count) {
    return TurnUntil([&] { return head_.made.size() == count && head_.at_work(); });
  }
  void ExpectEachMadeOnce() {
    EXPECT_EQ(head_.made.size(), kCount);
    for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
    EXPECT_EQ(marking_->ledger().count(PointState::kMade), kCount);
  }

  fs::path folder_;
  FrozenJob frozen_;
  FakeHead head_;
  cell::GrantInputs inputs_;
  std::unique_ptr<cell::PermissionChain> chain_;
  std::shared_ptr<cell::JournalWriter> journal_;
  std::unique_ptr<Marking> marking_;
};

TEST_F(MarkingTest, MakesEachMarkOnceInItsOrder) {
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  ExpectEachMadeOnce();
  EXPECT_EQ(marking_->run_count(), 1u);
  EXPECT_TRUE(std::is_sorted(head_.handed.begin(), head_.handed.end()));
}

TEST_F(MarkingTest, HandsOverNothingWhoseIntentIsNotOnDisk) {
  // Nobody gives the disk its time in these turns.
  for (int i = 0; i < 200; ++i) {
    inputs_.now += 5ms;
    marking_->Turn(inputs_);
    const auto durable = formats::ReadJournal(folder_ / kJournalFile);
    ASSERT_TRUE(durable);
    const auto history = formats::HistoryOf(*durable);
    for (const std::uint32_t mark : head_.handed) {
      EXPECT_TRUE(history[mark].open_intent ||
                  history[mark].outcome == formats::PointOutcome::kMade);
    }
    head_.Step();
  }
}

TEST_F(MarkingTest, WaitsForTheArm) {
  inputs_.permission_granted = false;
  EXPECT_FALSE(TurnUntil([&] { return !head_.handed.empty(); }, 100));
  EXPECT_THAT(marking_->message(), HasSubstr("permission of the job service"));
  inputs_.permission_granted = true;
  EXPECT_TRUE(ToItsEnd());
  ExpectEachMadeOnce();
}

TEST_F(MarkingTest, PausesAtTheEndOfTheMarkInHand) {
  ASSERT_TRUE(TillMade(3));
  inputs_.permission_granted = false;
  Turn();
  ASSERT_TRUE(head_.at_work());
  EXPECT_FALSE(marking_->waits()) << "a person who reads that it waits reaches into it";
  EXPECT_THAT(marking_->message(), HasSubstr("STILL AT WORK"));
  ASSERT_TRUE(TurnUntil([&] { return marking_->waits() && !head_.at_work(); }));
  EXPECT_THAT(marking_->message(), HasSubstr("permission"));
  EXPECT_EQ(head_.made.size(), 4u);
  EXPECT_EQ(marking_->ledger().count(PointState::kUncertain), 0u);
  EXPECT_FALSE(TurnUntil([&] { return head_.made.size() > 4; }, 100));
  inputs_.permission_granted = true;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  ExpectEachMadeOnce();
}

TEST_F(MarkingTest, EndsTheBeamAtOnceWhenThePermissionGrowsOld) {
  ASSERT_TRUE(TillMade(3));
  inputs_.permission_fresh = false;
  Turn();
  EXPECT_FALSE(head_.at_work());
  EXPECT_GE(head_.stops, 1);
  inputs_.permission_fresh = true;
  ASSERT_TRUE(ToItsEnd());
  // The mark in hand is begun and not ended: nobody made it again.
  EXPECT_EQ(marking_->ledger().count(PointState::kUncertain), 1u);
  EXPECT_EQ(marking_->ledger().count(PointState::kMade), kCount - 1);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

TEST_F(MarkingTest, AMachineThatCanRestHoldsForALatePermissionAndBreaksNothing) {
  head_.state_.can_hold = true;
  for (const bool in_a_pause : {false, true}) {
    ASSERT_TRUE(TillMade(head_.made.size() + 3));
    const std::size_t made = head_.made.size();
    if (in_a_pause) {
      inputs_.permission_granted = false;
      Turn();
    }
    inputs_.permission_fresh = false;
    EXPECT_FALSE(TurnUntil([&] { return head_.made.size() > made; }, 300));
    EXPECT_TRUE(head_.held());
    EXPECT_TRUE(head_.at_work());
    EXPECT_THAT(marking_->message(), HasSubstr("permission of the job service is late"));
    inputs_.permission_fresh = inputs_.permission_granted = true;
  }
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  ExpectEachMadeOnce();
  EXPECT_EQ(head_.stops, 0);
}

TEST_F(MarkingTest, AHoldEndsByWhatElseIsMissing) {
  head_.state_.can_hold = true;
  ASSERT_TRUE(TillMade(3));
  inputs_.permission_fresh = false;
  Turn();
  ASSERT_TRUE(head_.held());
  // The spindle was ended behind its longest rest.
  head_.state_.shutter_open = false;
  Turn();
  EXPECT_FALSE(head_.at_work());
  inputs_.permission_fresh = true;
  ASSERT_TRUE(TillMade(6));
  inputs_.permission_fresh = false;
  Turn();
  ASSERT_TRUE(head_.held());
  head_.state_.door_closed = false;
  ++head_.state_.openings;
  Turn();
  EXPECT_FALSE(head_.at_work());
  head_.state_.door_closed = inputs_.permission_fresh = true;
  EXPECT_FALSE(TurnUntil([&] { return head_.made.size() > 6; }, 100));
  inputs_.grant.number = 2;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_EQ(marking_->ledger().count(PointState::kUncertain), 2u);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

struct Opening {
  const char* name;
  void (*open)(FakeHead& head, cell::GrantInputs& inputs);
  void (*close)(FakeHead& head, cell::GrantInputs& inputs);
  intaglio_PauseReason reason;
};
constexpr Opening kOpenings[] = {
    {"the door",
     [](FakeHead& head, cell::GrantInputs&) {
       head.state_.door_closed = false;
       ++head.state_.openings;
     },
     [](FakeHead& head, cell::GrantInputs&) { head.state_.door_closed = true; },
     intaglio_PAUSE_INTERLOCK},
    {"the key",
     [](FakeHead& head, cell::GrantInputs&) {
       head.state_.key_on = false;
       ++head.state_.openings;
     },
     [](FakeHead& head, cell::GrantInputs&) { head.state_.key_on = true; },
     intaglio_PAUSE_INTERLOCK},
    {"the machine's stop",
     [](FakeHead& head, cell::GrantInputs&) {
       head.state_.stop_released = false;
       ++head.state_.openings;
     },
     [](FakeHead& head, cell::GrantInputs&) { head.state_.stop_released = true; },
     intaglio_PAUSE_EMERGENCY_STOP},
    {"a stop on the bus",
     [](FakeHead&, cell::GrantInputs& inputs) { inputs.stop_pressed = true; },
     [](FakeHead&, cell::GrantInputs& inputs) { inputs.stop_pressed = false; },
     intaglio_PAUSE_EMERGENCY_STOP},
    {"a fault",
     [](FakeHead& head, cell::GrantInputs&) { head.Break("the mirror is hot"); },
     [](FakeHead&, cell::GrantInputs&) {}, intaglio_PAUSE_FAULT},
};

TEST_F(MarkingTest, AnOpenInterlockInMidMarkCostsTheArm) {
  std::uint32_t broken = 0;
  for (const Opening& opening : kOpenings) {
    SCOPED_TRACE(opening.name);
    ASSERT_TRUE(TillMade(head_.made.size() + 1));
    opening.open(head_, inputs_);
    Turn();
    ++broken;
    EXPECT_FALSE(head_.at_work());
    const auto made = head_.made.size();
    opening.close(head_, inputs_);
    EXPECT_FALSE(TurnUntil([&] { return head_.made.size() > made; }, 200));
    EXPECT_TRUE(marking_->waits());
    EXPECT_TRUE(marking_->faulted());
    EXPECT_EQ(cell::PauseReasonOf(chain_->spent_by()), opening.reason);
    EXPECT_EQ(marking_->ledger().count(PointState::kUncertain), broken);
    ++inputs_.grant.number;  // a person arms again
  }
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_EQ(marking_->ledger().count(PointState::kMade), kCount - broken);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

// A job of one contour has no other: a person sees why it was broken, and may have it
// made.
TEST_F(MarkingTest, AHaltInTheLastMarkIsAnsweredByAPerson) {
  for (const bool again : {false, true}) {
    SCOPED_TRACE(again);
    head_.made.clear();
    head_.begun.clear();
    inputs_.fire_uncertain = false;
    fs::remove_all(folder_);
    Begin(SomeMarks(kCount));
    ASSERT_TRUE(TillMade(kCount - 1));
    kOpenings[0].open(head_, inputs_);
    Turn();
    kOpenings[0].close(head_, inputs_);
    EXPECT_FALSE(
        TurnUntil([&] { return marking_->activity() == Marking::Activity::kDone; }, 200));
    EXPECT_TRUE(marking_->waits());
    EXPECT_TRUE(marking_->faulted());
    EXPECT_THAT(marking_->message(), HasSubstr("then resume"));
    ++inputs_.grant.number;
    inputs_.fire_uncertain = again;
    ASSERT_TRUE(ToItsEnd()) << marking_->message();
    EXPECT_EQ(marking_->ledger().count(PointState::kMade), again ? kCount : kCount - 1);
    EXPECT_EQ(head_.begun[kCount - 1], again ? 2 : 1);
  }
}

TEST_F(MarkingTest, ALostLineIsSettledByTheMemory) {
  ASSERT_TRUE(TillMade(3));
  head_.Step();  // it has ended, and nobody is told
  head_.LoseLine();
  ASSERT_TRUE(TurnUntil([&] { return marking_->waits(); }));
  EXPECT_TRUE(marking_->lost_a_line());
  head_.RestoreLine();
  ++inputs_.grant.renewal;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  ExpectEachMadeOnce();
  EXPECT_EQ(marking_->settled_by_memory_count(), 1u);
}

TEST_F(MarkingTest, WithoutAnAnswerItIsUncertain) {
  head_.room = 2;
  ASSERT_TRUE(TillMade(3));
  head_.mute = true;
  head_.LoseLine();
  head_.RestoreLine();
  Turn();
  ++inputs_.grant.renewal;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_GE(marking_->ledger().count(PointState::kUncertain), 1u);
  EXPECT_EQ(marking_->ledger().count(PointState::kUncertain) +
                marking_->ledger().count(PointState::kMade),
            kCount);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

TEST_F(MarkingTest, AControllerWhoseProcessDoesNotRunIsWaitedFor) {
  ASSERT_TRUE(TillMade(3));
  head_.mute = head_.silent = true;
  head_.LoseHost();
  Turn();
  ++inputs_.grant.renewal;
  for (int i = 0; i < 1000; ++i) Turn();
  head_.mute = head_.silent = false;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_LE(marking_->ledger().count(PointState::kUncertain), 1u);
}

// It does not know what never came of a run that is longer than its memory.
TEST_F(MarkingTest, WhatNeverCameIsMade) {
  ASSERT_TRUE(TillMade(3));
  head_.forgets_of_run = 1;
  Restart();
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_EQ(marking_->ledger().count(PointState::kUncertain), 1u);
  EXPECT_EQ(marking_->ledger().count(PointState::kMade), kCount - 1);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

// As a mill: what the marker had armed when it died is not known, and that is one mark,
// however much room its controller has.
TEST_F(MarkingTest, OfAControllerWithoutMemoryOneMarkIsUncertain) {
  head_.state_.remembers_marks = false;
  head_.room = 64;
  ASSERT_TRUE(TillMade(3));
  Restart();
  ++inputs_.grant.number;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_EQ(marking_->ledger().count(PointState::kUncertain), 1u);
  EXPECT_EQ(marking_->ledger().count(PointState::kMade), kCount - 1);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

TEST_F(MarkingTest, APowerCycleLeavesWhatWasHandedOverUncertain) {
  ASSERT_TRUE(TillMade(3));
  head_.PowerCycle();
  EXPECT_FALSE(TurnUntil([&] { return head_.made.size() > 3; }, 1000));
  EXPECT_TRUE(marking_->faulted());
  ++inputs_.grant.number;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
  EXPECT_EQ(cell::CountsOf(marking_->ledger()).uncertain +
                cell::CountsOf(marking_->ledger()).made,
            kCount);
}

TEST_F(MarkingTest, ARestartAtEachInstantMakesNoMarkTwice) {
  for (int turns = 1; turns < 40; turns += 3) {
    SCOPED_TRACE(turns);
    int left = turns;
    TurnUntil([&] { return left-- == 0; });
    const bool in_hand = head_.at_work();
    const auto uncertain = marking_->ledger().count(PointState::kUncertain);
    if (marking_->phase() == Marking::Phase::kDone) break;
    Restart();
    ASSERT_TRUE(TurnUntil([&] { return marking_->phase() != Marking::Phase::kHalting; }));
    // Only the one in hand is not known to be whole.
    EXPECT_EQ(marking_->ledger().count(PointState::kUncertain),
              uncertain + (in_hand ? 1 : 0));
  }
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
  EXPECT_EQ(head_.made.size(), marking_->ledger().count(PointState::kMade));
  EXPECT_EQ(marking_->ledger().count(PointState::kMade) +
                marking_->ledger().count(PointState::kUncertain),
            kCount);
}

// The controller remembers the marks of the job before: they are no answer for this one.
TEST_F(MarkingTest, AKilledSecondJobIsNotSettledByTheMarksOfTheFirst) {
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  head_.made.clear();
  head_.begun.clear();
  frozen_.set_job_uid("job-2");
  frozen_.set_result_directory((folder_ / "second").string());
  Begin(SomeMarks(kCount));
  // Intents on disk, nothing handed over: a controller that is mute.
  head_.room = 0;
  ASSERT_TRUE(TurnUntil([&] { return marking_->phase() == Marking::Phase::kRunning; }));
  for (int i = 0; i < 20; ++i) Turn();
  head_.room = 4;
  Restart();
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  ExpectEachMadeOnce();
}

TEST_F(MarkingTest, UncertainMarksAreMadeAgainOnlyWithConsent) {
  frozen_.mutable_job()->set_when_uncertain(UNCERTAIN_POINTS_ASK);
  fs::remove_all(folder_);
  Begin(SomeMarks(kCount));
  ASSERT_TRUE(TillMade(3));
  head_.Break("the mirror is hot");
  EXPECT_FALSE(TurnUntil([&] { return head_.made.size() > 3; }, 200));
  EXPECT_TRUE(marking_->asks());
  EXPECT_THAT(marking_->message(), HasSubstr("--fire-uncertain"));
  ++inputs_.grant.number;
  inputs_.fire_uncertain = true;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_EQ(marking_->ledger().count(PointState::kMade), kCount);
  EXPECT_EQ(head_.begun[3], 2);
  EXPECT_EQ(head_.made[3], 1);
}

TEST_F(MarkingTest, AShutterThatDoesNotOpenIsAFault) {
  head_.opens_shutter = false;
  ASSERT_TRUE(TurnUntil([&] { return marking_->faulted(); }));
  EXPECT_THAT(marking_->message(), HasSubstr("shutter"));
  EXPECT_TRUE(head_.handed.empty());
}

// As a controller does that was not permitted the beam in time.
TEST_F(MarkingTest, AShutterThatClosesInMidMarkNamesTheLoadAndEndsTheMarkInHand) {
  ASSERT_TRUE(TillMade(2));
  head_.opens_shutter = false;
  ASSERT_TRUE(TurnUntil([&] { return marking_->faulted(); }));
  EXPECT_THAT(marking_->message(), HasSubstr("this computer was too busy"));
  EXPECT_FALSE(head_.at_work());
  const auto made = head_.made.size();
  head_.opens_shutter = true;
  EXPECT_FALSE(TurnUntil([&] { return head_.made.size() > made; }, 200));
  ++inputs_.grant.number;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  EXPECT_LE(marking_->ledger().count(PointState::kUncertain), 1U);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

TEST_F(MarkingTest, ACancelledJobEndsAtOnce) {
  ASSERT_TRUE(TillMade(3));
  marking_->Stop("the job was cancelled");
  ASSERT_TRUE(ToItsEnd());
  EXPECT_EQ(head_.made.size(), 3u);
  EXPECT_EQ(marking_->message(), "the job was cancelled");
}

TEST_F(MarkingTest, WhatLiesBeforeThePlaceToGoOnFromIsLeftOut) {
  inputs_.first_point = 5;
  ASSERT_TRUE(ToItsEnd());
  EXPECT_EQ(marking_->ledger().count(PointState::kLeftOut), 5u);
  EXPECT_EQ(head_.made.size(), kCount - 5);
}

TEST_F(MarkingTest, AWebThatRunsTooFastIsWaitedForBeforeAnythingIsBegun) {
  frozen_.mutable_machine()->mutable_scan_head()->set_field_mm(60);
  frozen_.mutable_machine()->mutable_scan_head()->set_jump_mm_s(5000);
  frozen_.mutable_job()->mutable_marks()->mutable_web();
  head_.state_.web_mm_s = 4'000;
  fs::remove_all(folder_);
  Begin(MarksOnAWeb(kCount));
  EXPECT_FALSE(TurnUntil([&] { return !head_.handed.empty(); }, 50));
  EXPECT_EQ(marking_->phase(), Marking::Phase::kWaiting);
  EXPECT_THAT(marking_->message(), HasSubstr("the web runs at 4000.0 mm/s, and all marks "
                                             "are made up to "));
  head_.state_.web_mm_s = 1'000;
  ASSERT_TRUE(ToItsEnd());
  ExpectEachMadeOnce();
}

TEST_F(MarkingTest, AWebThatRestsIsNamed) {
  frozen_.mutable_machine()->mutable_scan_head()->set_field_mm(60);
  frozen_.mutable_machine()->mutable_scan_head()->set_jump_mm_s(5000);
  frozen_.mutable_job()->mutable_marks()->mutable_web();
  fs::remove_all(folder_);
  Begin(MarksOnAWeb(kCount));
  const std::string text = "the web rests: start its drive";
  EXPECT_TRUE(TurnUntil([&] { return marking_->message() == text; }, 50));
  head_.state_.web_mm_s = 1'000;
  EXPECT_TRUE(TurnUntil([&] { return marking_->message().empty(); }, 50));
}

/// Repeats of three marks, each at its print mark.
class MarkingByPrint : public MarkingTest {
 protected:
  static constexpr std::uint32_t kOfRepeat = 3;

  void BeginByPrint() {
    frozen_.mutable_machine()->mutable_scan_head()->set_field_mm(60);
    frozen_.mutable_machine()->mutable_scan_head()->set_jump_mm_s(5000);
    frozen_.mutable_machine()->mutable_scan_head()->set_eye_mm(200);
    Marks& marks = *frozen_.mutable_job()->mutable_marks();
    marks.mutable_repeats()->set_pitch_mm(50);
    marks.mutable_web()->mutable_eye()->set_offset_mm(-4);
    marks.mutable_web()->mutable_eye()->set_max_missing(5);
    mark::MarkSet set = SomeMarks(kCount);
    for (std::uint32_t i = 0; i < kCount; ++i)
      set.marks[i].web_mm = 50.0 * (i / kOfRepeat);
    fs::remove_all(folder_);
    Begin(std::move(set));
  }
  formats::PointHistory HistoryOf(std::uint32_t mark) {
    return formats::HistoryOf(formats::ReadJournal(folder_ / kJournalFile).value())[mark];
  }
  void ExpectLeftOut(std::uint32_t mark, formats::MarkSkip why) {
    EXPECT_EQ(marking_->ledger().state(mark), PointState::kLeftOut) << mark;
    EXPECT_EQ(HistoryOf(mark).outcome, formats::PointOutcome::kLeftOut) << mark;
    EXPECT_EQ(HistoryOf(mark).reason, static_cast<std::uint8_t>(why)) << mark;
    EXPECT_FALSE(head_.made.contains(mark)) << mark;
  }
};

TEST_F(MarkingByPrint, ARepeatWithoutAPrintMarkIsLeftOutForGood) {
  head_.without_print = {3, 4, 5};
  BeginByPrint();
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  ASSERT_TRUE(head_.eye);
  EXPECT_EQ(head_.eye->pitch_mm, 50);
  EXPECT_EQ(head_.eye->offset_mm, -4);
  EXPECT_EQ(head_.eye->tolerance_mm, 1);
  EXPECT_EQ(head_.eye->max_missing, 5u);
  EXPECT_EQ(head_.eye->first_repeat, 0u);
  EXPECT_EQ(head_.made.size(), kCount - 3);
  for (const std::uint32_t mark : {3u, 4u, 5u})
    ExpectLeftOut(mark, formats::MarkSkip::kNoPrintMark);
  EXPECT_EQ(marking_->run_count(), 1u);
}

TEST_F(MarkingByPrint, BehindAPauseTheRestOfARepeatIsLeftOut) {
  BeginByPrint();
  ASSERT_TRUE(TillMade(3));
  inputs_.permission_granted = false;
  ASSERT_TRUE(TurnUntil([&] { return marking_->waits() && !head_.at_work(); }));
  ASSERT_EQ(head_.made.size(), 4u);
  inputs_.permission_granted = true;
  ASSERT_TRUE(ToItsEnd()) << marking_->message();
  // One mark of the second repeat was made.
  EXPECT_EQ(head_.eye->first_repeat, 2u);
  for (const std::uint32_t mark : {4u, 5u})
    ExpectLeftOut(mark, formats::MarkSkip::kRepeatBegun);
  EXPECT_EQ(head_.made.size(), kCount - 2);
  for (const auto& [mark, times] : head_.begun) EXPECT_EQ(times, 1) << mark;
}

TEST_F(MarkingByPrint, AnotherLifeLeavesOutTheRestToo) {
  BeginByPrint();
  ASSERT_TRUE(TillMade(4));
  Restart();
  inputs_.grant = {2, 0};
  ASSERT_TRUE(TurnUntil([&] { return marking_->asks() || ToItsEnd(); }));
  for (const std::uint32_t mark : {4u, 5u}) EXPECT_FALSE(head_.made.contains(mark));
  EXPECT_EQ(HistoryOf(5).reason,
            static_cast<std::uint8_t>(formats::MarkSkip::kRepeatBegun));
}

}  // namespace
}  // namespace intaglio::marker
