// bin/virtual-engraver behind its two pseudo-terminals, as a host meets it.

#include "tests/services/virtual_engraver/engraver_process.h"

#include <gmock/gmock.h>
#include <signal.h>

#include "tests/services/virtual_engraver/stage_path.h"
#include "tests/test_folder.h"

namespace intaglio::virtual_engraver {
namespace {

using intaglio::testing::Eventually;
using link::LaserFrame;
using link::MotionFrame;
using ::testing::HasSubstr;
using namespace std::chrono_literals;
using namespace std::string_literals;

link::ArmWindow AllFrom(std::uint64_t first_tick, std::size_t count, bool gated = false) {
  return {first_tick, gated, std::vector<bool>(count, true), false, 30};
}

/// Over pseudo-terminals and over TCP.
class EngraverLines : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Of, EngraverLines, ::testing::Bool(),
                         [](const auto& tcp) { return tcp.param ? "tcp" : "pty"; });

TEST_P(EngraverLines, CarryAShortJob) {
  EngraverProcess engraver(test::FreshFolder(), {}, {}, GetParam());
  ASSERT_TRUE(engraver.AwaitReady()) << engraver.program().Output();
  EngravingHost host(engraver);
  ASSERT_TRUE(host.Connect());
  ASSERT_TRUE(host.OpenShutterAndLamp());
  // Ten points, one a tick at 10 mm/s, after a lead-in of ten ticks to 10 mm height.
  const std::uint64_t start = host.TickNow() + 20;
  std::vector<Knot> knots = {{{500, 5000, 10000}, {0, 0, 0}, 40 * kTick},
                             {{600, 5000, 10000}, {10000, 0, 0}, 2 * kTick, true}};
  for (int i = 1; i < 10; ++i) {
    knots.push_back({{600.0 + 100 * i, 5000, 10000}, {10000, 0, 0}, kTick, true});
  }
  knots.push_back({{1600, 5000, 10000}, {0, 0, 0}, 2 * kTick, false, true});
  ASSERT_TRUE(host.Send(MotionFrame::kBeginRun, Encode(link::BeginRun{1, start})));
  ASSERT_TRUE(host.Send(MotionFrame::kSegments, Encode(Frame(knots))));
  ASSERT_TRUE(host.Send(LaserFrame::kArmWindow, Encode(AllFrom(start + 1, 60, true))));
  ASSERT_TRUE(host.Until([&] { return host.received().fired_count() == 10; }));
  // Reported cracks are in the file.
  const auto record = formats::ReadGlassRecord(engraver.record_file());
  ASSERT_TRUE(record.has_value());
  ASSERT_EQ(record->cracks.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(record->cracks[i].tick, start + 42 + i);
    const Vec3 planned(0.6 + 0.1 * static_cast<double>(i), 5, 10);
    EXPECT_LT((record->cracks[i].position_mm - planned).norm(), 1e-6) << i;
  }
  EXPECT_EQ(engraver.StatusOf("cracks"), "10");

  engraver.program().Signal(SIGTERM);
  const auto ended = engraver.program().WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_NE(ended.output.find("ends with 10 cracks"), std::string::npos) << ended.output;
}

TEST(EngraverProcess, ReportsTheSerialNumbersItIsGiven) {
  const auto identities = [](const std::string& truth) {
    EngraverProcess engraver(test::FreshFolder(), truth);
    EXPECT_TRUE(engraver.AwaitReady()) << engraver.program().Output();
    EngravingHost host(engraver);
    EXPECT_TRUE(host.Connect());
    return std::pair(host.received().laser_identities.back().serial_number,
                     host.received().motion_identities.back().serial_number);
  };
  EXPECT_EQ(identities(""), std::pair("virtual-laser-1"s, "virtual-stage-1"s));
  EXPECT_EQ(identities("laser { serial_number: 'A 03' } stage { serial_number: 'ST-7' }"),
            std::pair("A 03"s, "ST-7"s));
}

/// A host in a process of its own that fires every tick and stays there.
void FireForEver(const EngraverProcess& engraver) {
  EngravingHost host(engraver);
  if (!host.Connect() || !host.OpenShutterAndLamp()) return;
  const std::uint64_t tick = host.TickNow();
  if (!host.Send(LaserFrame::kArmWindow, Encode(AllFrom(tick + 5, 4096)))) return;
  host.Until([] { return false; }, 60s);
}

TEST_P(EngraverLines, OfAHostThatDiesOrHangsLeaveClosedShutters) {
  for (const int signal_number : {SIGKILL, SIGSTOP}) {
    EngraverProcess engraver(test::FreshFolder(), {}, {}, GetParam());
    ASSERT_TRUE(engraver.AwaitReady()) << engraver.program().Output();
    const ForkedHost host([&] { FireForEver(engraver); });
    ASSERT_TRUE(Eventually([&] { return engraver.StatusOf("shutters") == "1"; }, 5s));
    ASSERT_TRUE(Eventually(
        [&] {
          const std::string pulses = engraver.StatusOf("pulses");
          return !pulses.empty() && pulses != "0";
        },
        5s));
    host.Signal(signal_number);
    const auto silent_from = std::chrono::steady_clock::now();
    ASSERT_TRUE(Eventually([&] { return engraver.StatusOf("shutters") == "0"; }, 2s));
    // 250 ms, and the delay after which a loaded computer runs the two programs.
    EXPECT_LT(std::chrono::steady_clock::now() - silent_from, 600ms);
    EXPECT_EQ(engraver.StatusOf("safe_state"), "true");
    const std::string pulses = engraver.StatusOf("pulses");
    std::this_thread::sleep_for(100ms);  // ten ticks in which nothing may come
    EXPECT_EQ(engraver.StatusOf("pulses"), pulses);
  }
}

TEST(EngraverProcess, KilledItLeavesARecordUpToTheLastCrackItReported) {
  EngraverProcess engraver(test::FreshFolder(), "laser { rates_hz: 1000 }");
  ASSERT_TRUE(engraver.AwaitReady()) << engraver.program().Output();
  EngravingHost host(engraver);
  ASSERT_TRUE(host.Connect());
  ASSERT_TRUE(host.OpenShutterAndLamp());
  const std::uint64_t first = host.TickNow() + 50;
  ASSERT_TRUE(host.Send(LaserFrame::kArmWindow, Encode(AllFrom(first, 4096))));
  ASSERT_TRUE(host.Until([&] { return host.received().fired_count() > 300; }));
  engraver.program().Signal(SIGKILL);
  ASSERT_TRUE(engraver.program().WaitForEnd(5s).in_time);
  host.Poll();  // what was still in the line
  const auto record = formats::ReadGlassRecord(engraver.record_file());
  ASSERT_TRUE(record.has_value());
  EXPECT_LT(record->torn_bytes, formats::kGlassRecordSize);
  EXPECT_GE(record->cracks.size(), host.received().fired_count());
  for (std::size_t i = 0; i < record->cracks.size(); ++i)
    ASSERT_EQ(record->cracks[i].tick, first + i);
}

TEST(EngraverProcess, MisbehavesAtTheTickItWasGiven) {
  EngraverProcess engraver(test::FreshFolder(), "laser { rates_hz: 1000 }",
                           {"--fault", "30 door open", "--fault", "60 key off"});
  ASSERT_TRUE(engraver.AwaitReady()) << engraver.program().Output();
  ASSERT_TRUE(Eventually(
      [&] {
        return engraver.program().Output().find("key off: ok") != std::string::npos;
      },
      5s));
  EXPECT_NE(engraver.program().Output().find("door open: ok"), std::string::npos);
  EXPECT_EQ(engraver.StatusOf("interlocks"), std::to_string(link::kStopReleased));
  EXPECT_EQ(engraver.Ask("open sesame").rfind("error ", 0), 0u);
  EXPECT_EQ(engraver.Ask("quit"), "ok");
  EXPECT_EQ(engraver.program().WaitForEnd(5s).exit_code, 0);
}

TEST(EngraverProcess, RefusesOptionsThatCannotBe) {
  const auto folder = test::FreshFolder();
  for (const std::vector<std::string>& options :
       std::vector<std::vector<std::string>>{{"--speed", "fast"}, {"--speed", "0"}}) {
    EngraverProcess engraver(folder, "", options);
    const auto ended = engraver.program().WaitForEnd(5s);
    EXPECT_EQ(ended.exit_code, 2) << options[0] << " " << options[1];
    EXPECT_NE(ended.output.find(options[0]), std::string::npos) << ended.output;
  }
  EngraverProcess bad_fault(folder, "", {"--fault", "door open"});
  EXPECT_EQ(bad_fault.program().WaitForEnd(5s).exit_code, 1);
}

TEST(EngraverProcess, RefusesATruthFileThatCannotBe) {
  EngraverProcess engraver(
      test::FreshFolder(),
      "laser { channels: 5 } block { size_mm { x: 10 y: -1 z: 10 } }");
  const auto ended = engraver.program().WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, 2);
  const std::string file = engraver.truth_file().string();
  EXPECT_THAT(ended.output, HasSubstr(file + ": laser.channels: 5 is outside 1..4\n"));
  EXPECT_THAT(ended.output, HasSubstr(file + ": block.size_mm.y: -1 is outside"));
}

}  // namespace
}  // namespace intaglio::virtual_engraver
