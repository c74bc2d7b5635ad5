// The HAL files of a beam (start --beam) alone: on in each period whose row asks for it,
// for 250 ms from a permission, and in no other.
#include <algorithm>

#include "tests/services/drivers/linuxcnc/hal_configuration.h"

namespace intaglio::linuxcnc {
namespace {

class HalBeam : public HalConfiguration {
 protected:
  bool has_beam() const override { return true; }
  /// An edge of the bit; with it the heartbeat goes on.
  void Permit() {
    lamp_ = false, Send(0);
    lamp_ = true, Send(1);
  }
  /// Rows that all ask for the beam, with permissions in advance: this process may be
  /// late, and HAL plays a command a period.
  void PlayLit(std::size_t count, std::size_t permitted_periods) {
    AwaitCommands();
    for (std::size_t i = 0; i < count + 300; ++i) {
      lamp_ = i < permitted_periods && i % 10 == 0;
      Send(i % 2 == 0 ? 0 : 1);
    }
    for (std::size_t i = 0; i < count; ++i) {
      Row row;
      row.fire = row.gated = 1;
      Write(row);
    }
    Await([number = number_](const Sample& s) { return s.number >= number; });
  }
};

TEST_F(HalBeam, IsOnInEachPeriodWhoseRowAsksForIt) {
  AwaitCommands();
  for (int i = 0; i < 500; ++i) {
    lamp_ = i % 10 == 0;
    Send(i % 2 == 0 ? 0 : 1);
  }
  std::vector<int> asks;
  for (int i = 0; i < 120; ++i) asks.push_back(i >= 20 && i < 100 && i != 60 ? 1 : 0);
  for (const int fire : asks) {
    Row row;
    row.fire = row.gated = fire;
    Write(row);
  }
  Await([number = number_](const Sample& s) { return s.number >= number; });
  std::size_t next = 0;
  for (const Sample& s : Samples()) {
    EXPECT_TRUE(s.fresh() || !s.laser()) << "on without a row";
    if (!s.fresh()) continue;
    ASSERT_LT(next, asks.size());
    EXPECT_EQ(s.laser(), asks[next] != 0) << "row " << next;
    ++next;
  }
  EXPECT_EQ(next, asks.size());
  EXPECT_TRUE(machine_->RecordedTicks().empty()) << "each period of a beam is recorded";
}

TEST_F(HalBeam, EndsBehindItsPermissionWhateverTheHostPlays) {
  PlayLit(900, 200);
  long last_permission = 0, last_lit = 0;
  bool was_lamp = false;
  for (const Sample& s : Samples()) {
    if (s.laser()) last_lit = s.period;
    const bool lamp = (s.flags & 0x2000) != 0;
    if (lamp && !was_lamp) last_permission = s.period;
    was_lamp = lamp;
  }
  ASSERT_GT(last_permission, 0);
  EXPECT_GT(last_lit, last_permission + 200);
  EXPECT_LE(last_lit, last_permission + 251);
  EXPECT_TRUE(Samples().back().laser_ok()) << "the host was alive all the time";
}

TEST_F(HalBeam, EndsByTheWatchdogWhenTheHostIsDead) {
  AwaitCommands();
  Permit();
  for (int i = 0; i < 900; ++i) {
    Row row;
    row.fire = row.gated = 1;
    Write(row);
  }
  Await([number = number_](const Sample& s) { return s.number > number - 700; });
  // Await beats; from here on nothing does.
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  const auto samples = Samples();
  long last_beat = 0, last_lit = 0, command = 0;
  for (const Sample& s : samples) {
    if (s.laser()) last_lit = s.period;
    if (s.command != command) last_beat = s.period;
    command = s.command;
  }
  EXPECT_LE(last_lit, last_beat + 203);
  EXPECT_FALSE(samples.back().laser());
}

class HalBeamClosed : public HalBeam,
                      public ::testing::WithParamInterface<const char*> {};

TEST_P(HalBeamClosed, HasNoBeam) {
  PlayLit(50, 400);
  ASSERT_EQ(LaserPeriods(), 50);
  machine_->Command(fmt::format("sets {} 0", GetParam()));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  PlayLit(50, 400);
  EXPECT_EQ(LaserPeriods(), 50);
  machine_->Command(fmt::format("sets {} 1", GetParam()));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  PlayLit(50, 400);
  EXPECT_EQ(LaserPeriods(), 50) << "it comes back by itself";
}

INSTANTIATE_TEST_SUITE_P(For, HalBeamClosed,
                         ::testing::Values("key-on", "door-closed", "stop-released",
                                           "drives-ready"),
                         [](const auto& input) {
                           std::string name = input.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace intaglio::linuxcnc
