// The supplied HAL files alone, without any driver: rows and commands are written by
// halstreamer, and halsampler shows what the axes and the laser do.
#include "tests/services/drivers/linuxcnc/hal_configuration.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <numeric>

#include "services/drivers/linuxcnc/hal_folder.h"
#include "services/drivers/linuxcnc/hal_session.h"

namespace intaglio::linuxcnc {
namespace {

using std::chrono::milliseconds;

constexpr double kPeriod_s = 1e-3, kSpeed_mm_s = 50, kRamp_mm_s2 = 1000;

/// At 50 mm/s, after a ramp; every tenth row of the cruise fires, gated.
std::vector<Row> Cruise(int periods) {
  std::vector<Row> rows;
  for (int i = 1; i <= 50; ++i) {
    const double t = i * kPeriod_s;
    rows.push_back({1, 0, 7, 3, 0, 0, kRamp_mm_s2 / 2 * t * t});
  }
  for (int i = 1; i <= periods; ++i)
    rows.push_back({1 + i / 10, 0, 7, 3, i % 10 == 0 ? 1 : 0, 1,
                    1.25 + kSpeed_mm_s * i * kPeriod_s});
  return rows;
}

TEST_F(HalConfiguration, PlaysEveryRowOnceAtItsPeriodWithItsPulse) {
  std::vector<Row> rows = Cruise(400);
  const double end_mm = rows.back().x_mm;
  for (int i = 1; i <= 50; ++i) {
    const double t = i * kPeriod_s;
    rows.push_back(
        {50, 0, 7, 3, 0, 0, end_mm + kSpeed_mm_s * t - kRamp_mm_s2 / 2 * t * t});
  }
  Play(rows);
  long next = 1, first_period = 0;
  for (const Sample& s : Samples()) {
    if (!s.fresh()) continue;
    ASSERT_EQ(s.number, next);
    if (next == 1) first_period = s.period;
    EXPECT_EQ(s.period, first_period + next - 1) << "a row is not one period long";
    const Row& row = rows[static_cast<std::size_t>(next - 1)];
    // The report has six decimals.
    EXPECT_NEAR(s.x_mm, row.x_mm, 1.1e-6) << "row " << next;
    EXPECT_EQ(s.laser(), row.fire != 0) << "row " << next;
    ++next;
  }
  EXPECT_EQ(next, static_cast<long>(rows.size()) + 1);
  EXPECT_EQ(machine_->RecordedTicks().size(), 40u);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(machine_->RecordedTicks()[i], i + 2);
}

TEST_F(HalConfiguration, TurnsTheLaserOffAndRestsWhenTheRowsEnd) {
  std::vector<Row> rows = Cruise(100);
  for (Row& row : rows) row.fire = 1, row.gated = 0;
  Play(rows);
  const auto samples = Samples();
  long last = 0;
  for (const Sample& s : samples) {
    if (s.fresh()) last = s.period;
    EXPECT_EQ(s.laser(), s.fresh()) << "period " << s.period;
  }
  EXPECT_GT(last, 0);
  // 50 mm/s at 8000 mm/s^2: rest after 7 ms, back at the last row after as long again.
  for (const Sample& s : samples) {
    if (s.period > last + 30) {
      EXPECT_NEAR(s.x_mm, rows.back().x_mm, 1.1e-6);
    }
  }
}

// 88 um a period is a speed behind which the limits, as LinuxCNC has them by default, go
// 4 um to and fro about the place for ever.
TEST_F(HalConfiguration, BrakesToRestFromEverySpeed) {
  double place_mm = 0;
  for (const double step_um : {88, 132, 12, 25, 50}) {
    std::vector<Row> rows;
    for (int i = 1; i <= 50; ++i)
      rows.push_back({1, 0, 7, 3, 0, 0, place_mm + step_um * 1e-3 * i});
    Play(rows);
    place_mm = rows.back().x_mm;
    long last = 0;
    const auto samples = Samples();
    for (const Sample& s : samples)
      if (s.fresh()) last = s.period;
    ASSERT_GT(samples.back().period, last + 80);
    for (const Sample& s : samples) {
      if (s.period <= last + 80) continue;
      ASSERT_NEAR(s.x_mm, place_mm, 1.1e-6) << step_um << " um, period " << s.period;
    }
  }
}

TEST_F(HalConfiguration, IsOffAndAtRestWithin250MsAfterTheLastHeartbeat) {
  std::vector<Row> rows = Cruise(1000);
  for (Row& row : rows) row.fire = 1;
  Play(rows, false);
  long last_beat = 0, last_laser = 0, last_move = 0, command = 0;
  double x_mm = 0;
  const auto samples = Samples();
  for (const Sample& s : samples) {
    if (s.laser()) last_laser = s.period;
    if (s.x_mm != x_mm) last_move = s.period;
    x_mm = s.x_mm;
  }
  for (const Sample& s : samples) {
    if (s.command != command && s.period <= last_laser) last_beat = s.period;
    command = s.command;
  }
  ASSERT_GT(last_laser, last_beat);
  // 200 ms, and a period or two.
  EXPECT_LE(last_laser, last_beat + 203);
  EXPECT_LE(last_move, last_beat + 240) << "the axes do not stop";
  EXPECT_LT(x_mm, 40.0);
  EXPECT_FALSE(samples.back().laser_ok()) << "heartbeats alone open the gate again";
}

struct Closed {
  friend void PrintTo(const Closed& closed, std::ostream* out) { *out << closed.name; }
  const char* name;
  const char* command;  // of halcmd
  void (*spoil)(Row& row);
};
void Leave(Row&) {}

class HalGate : public HalConfiguration, public ::testing::WithParamInterface<Closed> {};

TEST_P(HalGate, LetsNoPulsePass) {
  std::vector<Row> rows(20);
  for (Row& row : rows) row.fire = 1;
  Play(rows);
  ASSERT_EQ(LaserPeriods(), 20) << "the gate is closed before";
  if (GetParam().command[0] != 0) machine_->Command(GetParam().command);
  Beat(milliseconds(100));
  for (Row& row : rows) GetParam().spoil(row);
  Play(rows);
  EXPECT_EQ(LaserPeriods(), 20);
}

INSTANTIATE_TEST_SUITE_P(
    For, HalGate,
    ::testing::Values(Closed{"key", "sets key-on 0", &Leave},
                      Closed{"door", "sets door-closed 0", &Leave},
                      Closed{"stop", "sets stop-released 0", &Leave},
                      Closed{"drives", "sets drives-ready 0", &Leave},
                      Closed{"torn_row", "", [](Row& row) { row.again_off = 1; }},
                      Closed{"another_arm", "", [](Row& row) { row.arm = 8; }},
                      Closed{"out_of_place", "",
                             [](Row& row) {
                               row.gated = 1, row.x_mm = 90, row.motion = 4;
                             }}),
    [](const auto& closed) { return std::string(closed.param.name); });

TEST_F(HalConfiguration, NeedsShutterLampArmAndWholeCommands) {
  std::vector<Row> rows(20);
  for (Row& row : rows) row.fire = 1;
  bool* const bits[] = {&shutter_, &lamp_};
  for (bool* bit : bits) {
    *bit = false;
    Play(rows);
    EXPECT_EQ(LaserPeriods(), 0);
    *bit = true;
    Await([](const Sample& s) { return (s.flags & 512) != 0; });
  }
  arm_ = 6;
  Play(rows);
  EXPECT_EQ(LaserPeriods(), 0);
  arm_ = 7;
  command_off_ = 1;
  Play(rows);
  EXPECT_EQ(LaserPeriods(), 0);
}

TEST_F(HalConfiguration, HoldsAStopUntilItIsReset) {
  std::vector<Row> rows(20);
  for (Row& row : rows) row.fire = 1;
  stop_ = true, Send(0), stop_ = false;
  Play(rows);
  EXPECT_EQ(LaserPeriods(), 0);
  reset_ = true, Send(0), reset_ = false;
  Play(rows);
  EXPECT_EQ(LaserPeriods(), 20);
}

TEST_F(HalConfiguration, CountsOpenings) {
  long openings = 0;
  for (const char* input : {"key-on", "door-closed", "stop-released", "key-on"}) {
    machine_->Command(fmt::format("sets {} 0", input));
    ++openings;
    Await([&](const Sample& s) { return s.openings == openings; });
    machine_->Command(fmt::format("sets {} 1", input));
    Await([](const Sample& s) { return (s.flags & 0x70) == 0x70; });
    Beat(milliseconds(50));
  }
  EXPECT_EQ(Samples().back().openings, 4);
}

// It would take away the record of pulses from which the next host reads what was fired.
TEST_F(HalConfiguration, ASecondStartInItsFolderIsRefusedAndChangesNothing) {
  std::vector<Row> rows(20);
  for (Row& row : rows) row.fire = 1;
  Play(rows);
  const auto pulses = machine_->RecordedTicks();
  ASSERT_FALSE(pulses.empty());
  const std::string folder = machine_->folder().string();
  const std::string identity = test::ContentOf(folder + "/identity");
  EXPECT_NE(std::system(fmt::format("'{}/deploy/linuxcnc/start' '{}' < /dev/null > "
                                    "'{}/again.log' 2>&1",
                                    INTAGLIO_SOURCE_DIR, folder, folder)
                            .c_str()),
            0);
  EXPECT_NE(test::ContentOf(folder + "/again.log").find("runs already"),
            std::string::npos);
  EXPECT_EQ(test::ContentOf(folder + "/identity"), identity);
  EXPECT_EQ(machine_->RecordedTicks(), pulses);
}

// A computer has one HAL, and the programs of any driver reach it.
TEST_F(HalConfiguration, TheIdentityOfAnEndedHalCountsNoMore) {
  const std::filesystem::path folder = machine_->folder();
  EXPECT_TRUE(drivers::ReadHalIdentity(folder, "mark_line"));
  const std::string identity = test::ContentOf(folder / "identity");
  machine_->PowerOff();
  std::ofstream(folder / "identity") << identity;
  // Its processes end one after the other.
  for (int i = 0; i < 500 && drivers::ReadHalIdentity(folder, "mark_line"); ++i)
    std::this_thread::sleep_for(milliseconds(10));
  int opened = 0;
  drivers::HalSession session(
      [&]() -> Result<std::unique_ptr<drivers::HalLine>> {
        ++opened;
        return Fail(ErrorCode::kIo, "it was opened");
      },
      folder, {.line = "mark_line"}, [] { return std::chrono::seconds(1); });
  session.Poll();
  EXPECT_EQ(opened, 0);
  EXPECT_NE(session.message().find("no HAL runs in"), std::string::npos)
      << session.message();
}

}  // namespace
}  // namespace intaglio::linuxcnc
