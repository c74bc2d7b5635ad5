#include "services/synchronizer/cell_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/platform/bus/samples.h"
#include "tests/patience.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::synchronizer {
namespace {

using bus::Borrow;
using bus::View;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

const std::string kCell = "els-03", kSender = "synchronizer-1", kEmpty;

/// A bridge that answers each order as the test says, beside a drive with a clock of its
/// own.
class CellDriveTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(test::Eventually(
        [&] { return states_.matched_count() > 0 && moves_.matched_count() > 0; }));
    drive_.Start({.name = "job's place of the block", .axes = Vec3(1, 2, 3)}, "job",
                 now_);
  }
  /// Turns the drive until it has given another order or has ended.
  bool GivesAnotherOrder() {
    const std::uint64_t before = number_;
    (void)test::Eventually([&] {
      now_ += 50ms;
      drive_.Turn(now_);
      moves_.Take([this](const intaglio_ManualCommand& move) {
        if (move.kind != intaglio_MANUAL_NONE) number_ = move.number;
      });
      return number_ > before || !drive_.drives();
    });
    return number_ > before;
  }
  void Answer(intaglio_ManualAnswer answer, bool reports_missing,
              const std::string& message) {
    intaglio_ManualState state{};
    state.cell = Borrow(kCell);
    state.number = ++state_number_;
    state.held_by = state.refusal = state.axes = state.profile = Borrow(kEmpty);
    state.answered_sender = Borrow(kSender);
    state.answered_number = number_;
    state.answer = answer;
    state.message = Borrow(message);
    state.reports_missing = reports_missing;
    (void)states_.Write(state);
  }

  bus::Bus bus_{test::PrivateBusOptions(kCell)};
  bus::Writer<intaglio_ManualState> states_{bus_, bus::kManualState, kCell};
  bus::Reader<intaglio_ManualCommand> moves_{bus_, bus::kCellMove, kCell};
  CellDrive drive_{bus_, kCell, kSender};
  std::chrono::nanoseconds now_{1h};
  std::uint64_t number_ = 0, state_number_ = 0;
};

TEST_F(CellDriveTest, GivesTheOrderAgainToABridgeWithoutReports) {
  ASSERT_TRUE(GivesAnotherOrder());
  for (int i = 0; i < 5; ++i) {
    Answer(intaglio_MANUAL_REFUSED, true, "key and door are not known");
    ASSERT_TRUE(GivesAnotherOrder()) << drive_.message();
  }
  Answer(intaglio_MANUAL_DONE, false, "");
  EXPECT_FALSE(GivesAnotherOrder());
  EXPECT_EQ(drive_.message(), "");
}

TEST_F(CellDriveTest, EndsWhereTheReportsDoNotComeInTime) {
  ASSERT_TRUE(GivesAnotherOrder());
  now_ += CellDrive::kReportPatience;
  Answer(intaglio_MANUAL_REFUSED, true, "key and door are not known");
  EXPECT_FALSE(GivesAnotherOrder());
  EXPECT_THAT(drive_.message(), HasSubstr("not known"));
}

TEST_F(CellDriveTest, EndsWhereTheDoorIsOpen) {
  ASSERT_TRUE(GivesAnotherOrder());
  Answer(intaglio_MANUAL_REFUSED, false, "the door is open: close it");
  EXPECT_FALSE(GivesAnotherOrder());
  EXPECT_THAT(drive_.message(), HasSubstr("the door is open"));
}

}  // namespace
}  // namespace intaglio::synchronizer
