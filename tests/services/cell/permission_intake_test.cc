#include "services/cell/permission_intake.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::cell {
namespace {

using namespace std::chrono_literals;

const std::string kCell = "els-01", kJob = "job-7", kNobody, kSource = "console-a-1-1";
constexpr std::uint64_t kEpoch = 3;

class PermissionIntakeTest : public testing::Test {
 protected:
  void Permit(std::uint32_t speed_percent) {
    intaglio_Permission sample{};
    sample.cell = bus::Borrow(kCell);
    sample.job_uid = bus::Borrow(kJob);
    sample.operator_name = bus::Borrow(kNobody);
    sample.epoch = kEpoch;
    sample.granted = true;
    sample.grant = 5;
    sample.first_point = 9;
    sample.fire_uncertain = true;
    sample.speed_percent = speed_percent;
    ASSERT_TRUE(permissions_->Write(sample));
  }
  void SendStop(bool pressed) {
    const std::vector<host::StopPress> presses = {{kSource, 1}};
    const auto wire = host::WireOf(presses);
    intaglio_EmergencyStop sample{};
    sample.cell = bus::Borrow(kCell);
    sample.source = bus::Borrow(kSource);
    sample.number = ++stop_number_;  // a reset has one of its own
    sample.pressed = pressed;
    sample.operator_name = bus::Borrow(kNobody);
    sample.reason = bus::Borrow(kNobody);
    if (!pressed) bus::Borrow(sample.released, wire);
    ASSERT_TRUE(stops_.Write(sample));
  }
  /// Turns until `enough`; each with a time of its own.
  bool ReceiveUntil(const std::function<bool()>& enough) {
    return test::Eventually([&] {
      intake_.Receive(now_ += 1ms);
      return enough();
    });
  }
  GrantInputs Inputs() const { return intake_.InputsFor(kJob, kEpoch, now_); }

  bus::Bus bus_{test::PrivateBusOptions(kCell)};
  std::optional<bus::Writer<intaglio_Permission>> permissions_{std::in_place, bus_,
                                                               bus::kPermission, kCell};
  bus::Writer<intaglio_EmergencyStop> stops_{bus_, bus::kEmergencyStop, kCell};
  std::uint64_t stop_number_ = 0;
  PermissionIntake intake_{bus_, kCell};
  std::chrono::nanoseconds now_{1s};
};

TEST_F(PermissionIntakeTest, GivesAJobItsOwnPermissionAloneAndForItsLease) {
  Permit(80);
  ASSERT_TRUE(ReceiveUntil([&] { return Inputs().permission_granted; }));
  EXPECT_TRUE(Inputs().permission_fresh);
  EXPECT_EQ(Inputs().grant, (Grant{5, 0}));
  EXPECT_EQ(Inputs().first_point, 9u);
  EXPECT_TRUE(Inputs().fire_uncertain);
  EXPECT_EQ(Inputs().speed_percent, 80u);
  for (const GrantInputs& other :
       {intake_.InputsFor("job-8", kEpoch, now_),
        intake_.InputsFor(kJob, kEpoch + 1, now_), intake_.InputsFor("", kEpoch, now_)}) {
    EXPECT_FALSE(other.permission_granted);
    EXPECT_EQ(other.grant, Grant{});
    EXPECT_EQ(other.speed_percent, 100u);
    EXPECT_FALSE(other.fire_uncertain);
  }
  EXPECT_TRUE(intake_.InputsFor(kJob, kEpoch, now_ + 89ms).permission_fresh);
  EXPECT_FALSE(intake_.InputsFor(kJob, kEpoch, now_ + 90ms).permission_fresh);
}

// A process that was stopped for the time of a lease receives the last sample and the end
// of the writer in one turn.
TEST_F(PermissionIntakeTest, WithoutItsWriterItIsLateAndNotWithdrawn) {
  Permit(100);
  ASSERT_TRUE(ReceiveUntil([&] { return Inputs().permission_granted; }));
  permissions_.reset();
  ASSERT_TRUE(test::Eventually([&] {
    intake_.Receive(now_);
    return !Inputs().permission_granted;
  }));
  EXPECT_FALSE(Inputs().permission_fresh);
  permissions_.emplace(bus_, bus::kPermission, kCell);
  Permit(100);
  ASSERT_TRUE(ReceiveUntil([&] { return Inputs().permission_granted; }));
  EXPECT_TRUE(Inputs().permission_fresh);
}

TEST_F(PermissionIntakeTest, KeepsTheSpeedWithinItsRange) {
  for (const auto& [sent, kept] : {std::pair{0u, 1u}, {1000u, 140u}}) {
    Permit(sent);
    EXPECT_TRUE(
        ReceiveUntil([&, kept = kept] { return Inputs().speed_percent == kept; }));
  }
}

// Its reset names a press that this reader never received: a manual motion, a lamp or a
// run ends all the same, in that turn and no longer.
TEST_F(PermissionIntakeTest, APressThatIsReleasedAlreadyStopsOneTurn) {
  SendStop(false);
  ASSERT_TRUE(ReceiveUntil([&] { return intake_.stopped(); }));
  EXPECT_FALSE(intake_.stop().pressed());
  EXPECT_TRUE(Inputs().stop_pressed);
  intake_.Receive(now_ += 1ms);
  EXPECT_FALSE(intake_.stopped());
  EXPECT_FALSE(Inputs().stop_pressed);
}

TEST_F(PermissionIntakeTest, HoldsWhatAnotherListenerHolds) {
  const std::vector<host::StopPress> presses = {{kSource, 1}};
  intake_.Receive(now_);
  intake_.ReceiveHeld("motion bridge", host::WireOf(presses));
  EXPECT_TRUE(Inputs().stop_pressed);
  intake_.Receive(now_ += 1ms);
  EXPECT_TRUE(intake_.stop().pressed());
}

TEST_F(PermissionIntakeTest, AStopHoldsUntilItsReset) {
  SendStop(true);
  ASSERT_TRUE(ReceiveUntil([&] { return intake_.stopped(); }));
  intake_.Receive(now_ += 10s);
  EXPECT_TRUE(Inputs().stop_pressed);
  SendStop(false);
  EXPECT_TRUE(ReceiveUntil([&] { return !intake_.stopped(); }));
}

}  // namespace
}  // namespace intaglio::cell
