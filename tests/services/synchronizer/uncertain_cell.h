#pragma once

// Cells whose laser was switched off over armed points, and what a person makes of it.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {

inline constexpr std::uint32_t kPoints = 120;
inline constexpr std::uint32_t kMoreThanAWindow = 3000;  // of a lockstep machine

class Uncertain : public testing::TestWithParam<bool> {
 protected:
  bool lockstep() const { return GetParam(); }
  CellOptions Asking(std::uint32_t points = kPoints) const {
    return {.points = points, .lockstep = lockstep(), .asks_when_uncertain = true};
  }
};

/// The controller is switched off over a window of armed points.
inline void LeaveSomeUncertain(FakeCell& cell, std::uint64_t made) {
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(made)) << cell.Description();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
  cell.PowerCycle(std::chrono::milliseconds(100));
  ASSERT_TRUE(cell.StepUntil([&] {
    return cell.Count(PointState::kUncertain) > 0 && cell.Count(PointState::kArmed) == 0;
  })) << cell.Description();
}

/// Whatever the job service does by itself: nothing fires.
inline void ExpectItWaits(FakeCell& cell) {
  const std::size_t cracks = cell.laser.cracks().size();
  cell.StepFor(std::chrono::seconds(1));
  cell.RepeatGrant();
  cell.StepFor(std::chrono::seconds(1));
  cell.RenewGrant();
  cell.StepFor(std::chrono::seconds(1));
  EXPECT_EQ(cell.laser.cracks().size(), cracks);
  EXPECT_EQ(cell.laser.shutters(), 0);
  EXPECT_FALSE(cell.done());
  EXPECT_TRUE(cell.engraving->waits()) << cell.Description();
  EXPECT_TRUE(cell.engraving->faulted());
  EXPECT_FALSE(cell.engraving->lost_a_line()) << "or the job service lets it go on";
  EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("check the block"));
}

inline void LeaveThemAndEnd(FakeCell& cell) {
  const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_THAT(cell.Disagreements(), testing::IsEmpty());
  EXPECT_EQ(cell.Count(PointState::kUncertain), uncertain);
  EXPECT_EQ(cell.made(), cell.points_mm.size() - uncertain);
}

/// The line is cut over a window of armed points, and the controller will not know what
/// it fired. The line is back, and nothing is settled yet.
inline void LeaveSomeUnsettled(FakeCell& cell, std::uint64_t made) {
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(made)) << cell.Description();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
  cell.laser.forgets = true;
  cell.CutLine(true);
  ASSERT_TRUE(cell.StepUntil([&] { return cell.engraving->faulted(); }))
      << cell.Description();
  cell.StepFor(std::chrono::seconds(1));
  cell.CutLine(false);
  ASSERT_EQ(cell.Count(PointState::kUncertain), 0u);
  ASSERT_GT(cell.Count(PointState::kArmed), 0u);
}

/// The person does not wait for the line.
inline void FireUncertainAtOnce(FakeCell& cell) {
  cell.Withdraw();
  cell.StepFor(std::chrono::milliseconds(5));
  cell.Grant();
  cell.fire_uncertain = true;
}

inline std::size_t RecordsIn(const FakeCell& cell, formats::JournalKind kind) {
  const auto records = cell.JournalOnDisk().records;
  return static_cast<std::size_t>(
      std::count_if(records.begin(), records.end(),
                    [kind](const auto& record) { return record.kind == kind; }));
}
inline std::size_t ReopenedIn(const FakeCell& cell) {
  return RecordsIn(cell, formats::JournalKind::kReopened);
}

inline void FireThemAndEnd(FakeCell& cell) {
  const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
  const std::size_t reopened = ReopenedIn(cell);
  cell.GrantFiringUncertain();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_THAT(cell.Disagreements(), testing::IsEmpty());
  EXPECT_EQ(cell.made(), cell.points_mm.size());
  EXPECT_EQ(cell.engraving->ledger().unknown_count(), 0u);
  EXPECT_EQ(ReopenedIn(cell), reopened + uncertain) << "each once";
  EXPECT_LE(cell.laser.cracks().size(), cell.points_mm.size() + reopened + uncertain);
}

}  // namespace intaglio::synchronizer
