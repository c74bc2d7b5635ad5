// A disarm at each millisecond of a run of points: what lights afterwards is reported as
// fired, so that nobody makes it again.

#include <gtest/gtest.h>

#include "tests/services/drivers/grbl/grbl_cell.h"

namespace intaglio::drivers {
namespace {

constexpr int kDisarmedPoints = 24;
constexpr double kDisarmedPitch_mm = 0.3;

class GrblDisarm : public ::testing::TestWithParam<bool> {
 protected:
  /// `busy_ms`: the host turns once in so many. False: the run was over before `at_ms`.
  bool DisarmAt(int at_ms, int busy_ms) {
    GrblCell cell;
    cell.Prepare();
    cell.Begin(kDisarmedPoints, kDisarmedPitch_mm, GetParam());
    for (int i = 0; i < at_ms; i += busy_ms) {
      for (int k = 1; k < busy_ms; ++k) cell.machine.Advance();
      cell.Step();
    }
    if (cell.RunIsOver()) return false;
    cell.feeds = false;
    EXPECT_TRUE(cell.driver->Disarm());
    cell.Until([] { return false; }, 1500);
    const auto& flashes = cell.machine.grbl.motion().flashes();
    std::size_t fired = 0;
    for (const auto& [tick, outcome] : cell.outcomes)
      fired += outcome == link::TickOutcome::kFiredUnseen;
    EXPECT_EQ(flashes.size(), fired) << "disarmed at " << at_ms << " ms";
    for (const grbl::Flash& flash : flashes) {
      const bool reported = std::ranges::any_of(cell.outcomes, [&](const auto& one) {
        return one.first % 1000 + 1 == static_cast<std::uint64_t>(flash.line) &&
               one.second == link::TickOutcome::kFiredUnseen;
      });
      EXPECT_TRUE(reported) << "N" << flash.line << " of a disarm at " << at_ms << " ms";
    }
    return true;
  }
};

TEST_P(GrblDisarm, LeavesNoFlashThatIsNotReported) {
  for (const int busy_ms : {1, 7, 20}) {
    int at_ms = 0;
    while (!HasFailure() && DisarmAt(at_ms, busy_ms)) at_ms += busy_ms;
    EXPECT_GT(at_ms, 300);
  }
}

INSTANTIATE_TEST_SUITE_P(, GrblDisarm, ::testing::Bool(), [](const auto& row) {
  return row.param ? "AtRest" : "OnTheWay";
});

}  // namespace
}  // namespace intaglio::drivers
