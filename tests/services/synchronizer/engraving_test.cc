#include "services/synchronizer/engraving.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using testing::IsEmpty;
using namespace std::chrono_literals;
using Phase = Engraving::Phase;

class EngravingModes : public testing::TestWithParam<bool> {
 protected:
  FakeCell cell_{{.points = 60, .lockstep = GetParam()}};
};

INSTANTIATE_TEST_SUITE_P(Engraving, EngravingModes, testing::Bool(),
                         [](const auto& i) { return i.param ? "Lockstep" : "RealTime"; });

TEST_P(EngravingModes, MakesEveryPointOnceInOnePass) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_EQ(cell_.laser.cracks().size(), 60);
  EXPECT_EQ(cell_.engraving->run_count(), 1);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
  EXPECT_EQ(cell_.results.size(), 60);
  for (std::uint32_t i = 0; i < 60; ++i) EXPECT_EQ(cell_.results[i].point, i);
  // Off when it is over.
  cell_.StepFor(5ms);
  EXPECT_EQ(cell_.laser.shutters(), 0);
  EXPECT_FALSE(cell_.laser.lamp_on());
}

TEST_P(EngravingModes, HasTheIntentOnDiskBeforeTheControllerHearsOfTheTick) {
  int armed = 0;
  cell_.laser.on_arm = [&](std::uint64_t tick) {
    ++armed;
    const auto journal = formats::ReadJournal(cell_.journal_file);
    EXPECT_TRUE(std::any_of(journal->records.begin(), journal->records.end(),
                            [&](const formats::JournalRecord& record) {
                              return record.kind == JournalKind::kIntent &&
                                     record.tick == tick;
                            }))
        << "tick " << tick;
  };
  // A disk that is done with its work every 20 ms only: the windows have to wait for it.
  cell_.Grant();
  for (int step = 0; step < 20000 && armed < 20; ++step) {
    cell_.wait_for_disk = step % 20 == 0;
    cell_.Step();
  }
  EXPECT_GE(armed, 20);
}

}  // namespace
}  // namespace intaglio::synchronizer
