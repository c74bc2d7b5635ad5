#include "services/synchronizer/engraving/consent.h"

#include <gmock/gmock.h>

#include "services/synchronizer/engraving/engraving_inputs.h"
#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using testing::HasSubstr;
using namespace std::chrono_literals;

constexpr std::uint32_t kConsentPoints = 6;

EngravingJob JobThatAsks() {
  EngravingJob job;
  for (std::uint32_t i = 0; i < kConsentPoints; ++i)
    job.machine_points_mm.push_back(Vec3(i, 0.5, 0.25));
  job.asks_when_uncertain = true;
  return job;
}

/// A record whose points are made uncertain at will, and a chain that is clear or has
/// lost its grant.
class ConsentTest : public testing::Test {
 protected:
  ConsentTest() {
    inputs_.permission_fresh = inputs_.permission_granted = true;
    inputs_.grant.number = 1;
  }
  void Arm(std::uint32_t point) { ASSERT_TRUE(record_.Arm(10 + point, point)); }
  void MakeUncertain(std::uint32_t point) {
    Arm(point);
    record_.Resolve({10 + point, point, PointOutcome::kUncertain, SkipReason::kLink});
  }
  void GrantWithConsent() {
    ++inputs_.grant.number;
    inputs_.fire_uncertain = true;
  }
  std::vector<std::uint32_t> Reopened() {
    bool any = false;
    EXPECT_TRUE(consent_.Reopen(inputs_, any));
    std::vector<std::uint32_t> points;
    for (std::uint32_t i = 0; i < kConsentPoints; ++i) {
      if (record_.ledger().state(i) == PointState::kPlanned) points.push_back(i);
    }
    return points;
  }
  std::size_t ConsentsOnDisk() const {
    const auto records = journal_.OnDisk().records;
    return static_cast<std::size_t>(std::count_if(
        records.begin(), records.end(),
        [](const auto& record) { return record.kind == JournalKind::kConsent; }));
  }

  EngravingJob job_ = JobThatAsks();
  JournalBench journal_{kConsentPoints};
  PulseRecord record_{kConsentPoints, true, *journal_.writer,
                      [this](const PulseResult& r) { consent_.Note(r); }};
  PermissionChain chain_;
  EngravingInputs inputs_;
  Consent consent_{job_, record_, chain_};
};

/// All but these points are made, so that what Reopened returns was opened by consent.
void MakeAllBut(PulseRecord& record, std::initializer_list<std::uint32_t> points) {
  for (std::uint32_t i = 0; i < kConsentPoints; ++i) {
    if (std::find(points.begin(), points.end(), i) != points.end()) continue;
    ASSERT_TRUE(record.Arm(10 + i, i));
    record.Resolve({10 + i, i, PointOutcome::kMade, SkipReason::kNone});
  }
}

TEST_F(ConsentTest, WithoutItNothingIsOpened) {
  MakeAllBut(record_, {1, 2});
  MakeUncertain(1);
  MakeUncertain(2);
  ++inputs_.grant.number;
  consent_.TakeConsent(inputs_, false);
  EXPECT_THAT(Reopened(), testing::IsEmpty());
  EXPECT_EQ(ConsentsOnDisk(), 0u);
}

TEST_F(ConsentTest, OpensWhatIsUncertainWhenItIsTakenAndIsOnDiskFirst) {
  MakeAllBut(record_, {1, 2});
  MakeUncertain(1);
  GrantWithConsent();
  consent_.TakeConsent(inputs_, false);
  EXPECT_EQ(ConsentsOnDisk(), 1u);
  MakeUncertain(2);  // later: not covered
  EXPECT_THAT(Reopened(), testing::ElementsAre(1));
}

TEST_F(ConsentTest, CountsOnceForEachGrant) {
  MakeAllBut(record_, {1});
  MakeUncertain(1);
  GrantWithConsent();
  consent_.TakeConsent(inputs_, false);
  EXPECT_THAT(Reopened(), testing::ElementsAre(1));
  MakeUncertain(1);
  ++inputs_.grant.renewal;
  consent_.TakeConsent(inputs_, false);
  EXPECT_THAT(Reopened(), testing::IsEmpty());
  EXPECT_EQ(ConsentsOnDisk(), 1u);
}

TEST_F(ConsentTest, OfAnEarlierLifeItCountsNoMore) {
  MakeAllBut(record_, {1});
  MakeUncertain(1);
  job_.earlier.consent_grant = 2;
  Consent next(job_, record_, chain_);
  GrantWithConsent();
  ASSERT_EQ(inputs_.grant.number, 2u);
  next.TakeConsent(inputs_, false);
  bool any = false;
  EXPECT_TRUE(next.Reopen(inputs_, any));
  EXPECT_FALSE(any);
}

TEST_F(ConsentTest, CoversWhatIsArmedOnlyWhileAHaltIsSettled) {
  for (const bool settling : {false, true}) {
    SCOPED_TRACE(settling);
    const std::uint32_t point = settling ? 2 : 1;
    Arm(point);
    GrantWithConsent();
    consent_.TakeConsent(inputs_, settling);
    record_.Resolve({0, point, PointOutcome::kUncertain, SkipReason::kLink});
    bool any = false;
    EXPECT_TRUE(consent_.Reopen(inputs_, any));
    EXPECT_EQ(any, settling);
  }
}

TEST_F(ConsentTest, DoesNotCoverWhatLiesBeforeThePlaceToEngraveFrom) {
  MakeAllBut(record_, {1, 4});
  MakeUncertain(1);
  MakeUncertain(4);
  inputs_.first_point = 3;
  GrantWithConsent();
  consent_.TakeConsent(inputs_, false);
  EXPECT_THAT(Reopened(), testing::ElementsAre(4));
}

TEST_F(ConsentTest, IsTakenBackByAGrantWithoutIt) {
  MakeAllBut(record_, {1});
  MakeUncertain(1);
  GrantWithConsent();
  consent_.TakeConsent(inputs_, false);
  inputs_.fire_uncertain = false;
  ++inputs_.grant.number;
  consent_.TakeConsent(inputs_, false);
  EXPECT_THAT(Reopened(), testing::IsEmpty());
}

TEST_F(ConsentTest, IsNotTakenWhileTheJournalHasNoRoomForIt) {
  MakeAllBut(record_, {1});
  MakeUncertain(1);
  GrantWithConsent();
  journal_.Fill();
  consent_.TakeConsent(inputs_, false);
  EXPECT_THAT(Reopened(), testing::IsEmpty());
  journal_.AwaitDisk();
  consent_.TakeConsent(inputs_, false);
  EXPECT_THAT(Reopened(), testing::ElementsAre(1));
}

TEST_F(ConsentTest, TheQuestionIsAskedOnceAndNamesThePlaces) {
  inputs_.grant.number = 0;
  MakeUncertain(2);
  MakeUncertain(4);
  EXPECT_TRUE(consent_.asks());
  EXPECT_FALSE(consent_.MustAsk(inputs_)) << "there is no grant that it could cost";
  inputs_.grant.number = 1;
  EXPECT_TRUE(consent_.MustAsk(inputs_));
  const std::string question = consent_.Question();
  EXPECT_THAT(question, HasSubstr("fired: 2, at places 2..4 "));
  EXPECT_THAT(question, HasSubstr("the first at 2.000, 0.500, 0.250 mm"));
  consent_.NoteAsked();
  EXPECT_FALSE(consent_.MustAsk(inputs_));
  MakeUncertain(5);
  EXPECT_TRUE(consent_.MustAsk(inputs_)) << "it is about one more";
  consent_.BeginRun();
  EXPECT_FALSE(consent_.asks());
}

TEST_F(ConsentTest, ConsentToAllOfItIsTheAnswerBeforeItIsAsked) {
  MakeUncertain(1);
  GrantWithConsent();
  consent_.TakeConsent(inputs_, false);
  EXPECT_FALSE(consent_.MustAsk(inputs_));
  MakeUncertain(2);
  EXPECT_TRUE(consent_.MustAsk(inputs_)) << "of this one nobody has said anything";
}

TEST_F(ConsentTest, ASpentGrantIsNoAnswer) {
  MakeUncertain(1);
  GrantWithConsent();
  consent_.TakeConsent(inputs_, false);
  ChainLinks links;
  links.stop_not_pressed = true;
  links.grant = inputs_.grant;
  (void)chain_.Turn(links, 1s);
  chain_.Latch(false);
  EXPECT_TRUE(consent_.MustAsk(inputs_));
}

TEST_F(ConsentTest, AnOpenQuestionKeepsTheJobOpenUntilAGrantAfterIt) {
  MakeUncertain(1);
  EXPECT_TRUE(consent_.KeepsJobOpen(inputs_)) << "it was not asked yet";
  consent_.NoteAsked();
  EXPECT_FALSE(consent_.KeepsJobOpen(inputs_)) << "the chain is clear: a new grant";
  inputs_.permission_granted = false;
  EXPECT_TRUE(consent_.KeepsJobOpen(inputs_));
  inputs_.permission_granted = true;
  chain_.Latch(false);
  EXPECT_TRUE(consent_.KeepsJobOpen(inputs_));
}

TEST_F(ConsentTest, AJobThatDoesNotAskHasNoQuestionAndYetTakesConsent) {
  job_.asks_when_uncertain = false;
  Consent consent(job_, record_, chain_);
  MakeAllBut(record_, {1});
  MakeUncertain(1);
  consent.NoteUncertain();
  EXPECT_FALSE(consent.asks());
  EXPECT_FALSE(consent.KeepsJobOpen(inputs_));
  GrantWithConsent();
  consent.TakeConsent(inputs_, false);
  EXPECT_TRUE(consent.KeepsJobOpen(inputs_)) << "what it covers is to be made";
  bool any = false;
  EXPECT_TRUE(consent.Reopen(inputs_, any));
  EXPECT_TRUE(any);
  EXPECT_FALSE(consent.KeepsJobOpen(inputs_));
}

}  // namespace
}  // namespace intaglio::synchronizer
