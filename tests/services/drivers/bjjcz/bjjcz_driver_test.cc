// The driver of BJJCZ boards at a board of the tests' own, which records what beam and
// mirrors did: whatever is reported, that is what was made.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "services/drivers/bjjcz/board_profile.h"
#include "services/drivers/bjjcz/mark_lists.h"
#include "tests/services/drivers/bjjcz/bjjcz_rig.h"
#include "tests/services/drivers/marks/mark_conformance.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

constexpr double kPlacesPerMm = 65536.0 / 100;

mark::Pen FastPen() {
  mark::Pen pen;
  pen.name = "fast";
  pen.speed_mm_s = 1000;
  pen.power_ratio = 0.5;
  pen.frequency_hz = 20000;
  return pen;
}

/// The host, which permits every 20 ms, and the board.
class Host {
 public:
  explicit Host(const MachineSpec& profile)
      : machine_(profile.bjjcz_board().laser() == BJJCZ_LASER_FIBRE),
        driver_(MakeBjjczDriverAt(machine_, profile)) {}

  void Step() {
    machine_.Advance();
    if (permits && ++steps_ % 20 == 0) (void)driver_->Permit(true);
    driver_->Poll();
    for (const MarkEvent& event : driver_->TakeEvents()) {
      events.push_back(event);
      fates[event.mark] = event.fate;
    }
  }
  void StepFor(std::chrono::milliseconds time) {
    for (int i = 0; i < time.count(); ++i) Step();
  }
  bool Until(const std::function<bool()>& condition) {
    for (int i = 0; i < 60'000 && !condition(); ++i) Step();
    return condition();
  }
  bool Connect() {
    return Until([&] { return driver_->state().link_up && driver_->state().settled; });
  }
  Status Run(const mark::MarkSet& set, std::uint32_t run = 1) {
    if (const auto begun = driver_->Begin(run, set.pens); !begun) return begun;
    for (std::uint32_t i = 0; i < set.marks.size(); ++i) {
      if (const auto taken = driver_->Append({i, set.marks[i]}); !taken) return taken;
    }
    return driver_->Finish();
  }
  bool settled() {
    return Until([&] { return driver_->state().settled; });
  }
  MarkDriver& driver() { return *driver_; }
  BjjczMachine& machine() { return machine_; }
  bjjcz::VirtualBjjcz& board() { return machine_.board; }

  bool permits = true;
  std::vector<MarkEvent> events;
  std::map<std::uint32_t, MarkFate> fates;

 private:
  BjjczMachine machine_;
  std::unique_ptr<MarkDriver> driver_;
  int steps_ = 0;
};

/// A square, an arc and an open line; one longer than a list.
mark::MarkSet Drawing() {
  mark::MarkSet set{{FastPen(), FastPen()}, {}};
  set.pens[1].pass_count = 2;
  set.pens[1].speed_mm_s = 200;
  set.marks.push_back(
      {0, true, 0, {{Vec2(1, 1)}, {Vec2(11, 1)}, {Vec2(11, 11)}, {Vec2(1, 11)}}});
  set.marks.push_back({0, false, 0, {{Vec2(-20, 5), 1}, {Vec2(-10, 5)}}});
  set.marks.push_back({1, false, 0, {{Vec2(-40, -40)}, {Vec2(40, -30)}}});
  return set;
}

/// Length of the way with the beam on, mm, and how far it was from the marks' chords.
struct Lit {
  double length_mm = 0, largest_error_mm = 0;
};
double DistanceToMarks(const mark::MarkSet& set, const Vec2& at) {
  double best = 1e9;
  for (const mark::Mark& mark : set.marks) {
    auto way = mark::PlacesOf(mark, 1e-5);
    if (mark.closed) way.push_back(way.front());
    for (std::size_t i = 1; i < way.size(); ++i) {
      const Vec2 d = way[i] - way[i - 1];
      const double part =
          std::clamp((at - way[i - 1]).dot(d) / d.squaredNorm(), 0.0, 1.0);
      best = std::min(best, (at - way[i - 1] - part * d).norm());
    }
  }
  return best;
}
Lit LitOf(const mark::MarkSet& set, const std::vector<bjjcz::Stroke>& strokes) {
  Lit lit;
  for (const bjjcz::Stroke& stroke : strokes) {
    if (!stroke.is_mark) continue;
    const auto mm = [](const std::array<double, 2>& at) {
      return Vec2((at[0] - 32768) / kPlacesPerMm, (at[1] - 32768) / kPlacesPerMm);
    };
    const Vec2 from = mm(stroke.from), to = mm(stroke.to);
    lit.length_mm += (to - from).norm();
    for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0})
      lit.largest_error_mm =
          std::max(lit.largest_error_mm, DistanceToMarks(set, from + part * (to - from)));
  }
  return lit;
}

double LengthOfAll(const mark::MarkSet& set) {
  double length_mm = 0;
  for (const mark::Mark& mark : set.marks)
    length_mm += set.pens[mark.pen].pass_count * mark::LengthOf(mark);
  return length_mm;
}

class EveryLaser : public ::testing::TestWithParam<BjjczLaser> {};

// Half a place to each side by rounding, half a place of chords.
TEST_P(EveryLaser, MakesTheMarksAndNothingElse) {
  Host host(BjjczProfile(GetParam()));
  ASSERT_TRUE(host.Connect()) << host.driver().state().message;
  const mark::MarkSet set = Drawing();
  ASSERT_TRUE(host.Run(set));
  ASSERT_TRUE(host.settled());
  EXPECT_EQ(host.driver().state().fault, "");
  for (const std::uint32_t mark : {0U, 1U, 2U})
    EXPECT_EQ(host.fates[mark], MarkFate::kDone);
  const Lit lit = LitOf(set, host.board().strokes());
  EXPECT_LE(lit.largest_error_mm, 1.21 / kPlacesPerMm);
  EXPECT_NEAR(lit.length_mm, LengthOfAll(set), 0.02);
  double lit_us = 0, mark_us = 0;
  for (const bjjcz::Stroke& stroke : host.board().strokes()) {
    if (!stroke.is_mark) {
      EXPECT_LE(stroke.lit_us, 30 + 1e-6);  // laser_off_delay_s
      continue;
    }
    lit_us += stroke.lit_us;
    mark_us += stroke.end_us - stroke.begin_us;
  }
  // The delay of 20 us at the begin of each of its strokes is dark.
  EXPECT_GT(lit_us, 0.98 * mark_us);
  EXPECT_EQ(host.board().unknown_count(), 0);
}

TEST_P(EveryLaser, SetsPowerAndFrequency) {
  Host host(BjjczProfile(GetParam()));
  ASSERT_TRUE(host.Connect());
  ASSERT_TRUE(host.Run(Drawing()));
  ASSERT_TRUE(host.settled());
  const bjjcz::Stroke& stroke = host.board().strokes().back();
  if (GetParam() == BJJCZ_LASER_FIBRE) {
    EXPECT_EQ(stroke.current, 2048);          // half of 4095
    EXPECT_EQ(stroke.q_switch_period, 1000);  // 20 MHz / 20 kHz
  } else {
    EXPECT_EQ(stroke.mark_period, 500);  // 10 MHz / 20 kHz
    EXPECT_EQ(stroke.power_ratio, 500);  // half of 50 us, in 0.05 us
  }
}

INSTANTIATE_TEST_SUITE_P(Of, EveryLaser,
                         ::testing::Values(BJJCZ_LASER_FIBRE, BJJCZ_LASER_CO2,
                                           BJJCZ_LASER_UV));

// The board has no watchdog: what it holds when the host dies is all that ends the beam.
TEST(BjjczDriver, ABoardWithoutAHostIsDarkWithinThePermission) {
  for (int death_ms = 0; death_ms < 400; death_ms += 7) {
    Host host(BjjczProfile(BJJCZ_LASER_FIBRE));
    ASSERT_TRUE(host.Connect());
    ASSERT_TRUE(host.Run(Drawing()));
    ASSERT_TRUE(host.Until([&] { return host.board().lit(); }));
    host.StepFor(std::chrono::milliseconds(death_ms));
    // The newest permission is not older than a period.
    for (int ms = 0; ms < 250; ++ms) host.board().Advance(1000);
    const auto worked = host.board().work_count();
    for (int ms = 0; ms < 2000; ++ms) {
      host.board().Advance(1000);
      ASSERT_FALSE(host.board().lit()) << death_ms;
    }
    EXPECT_EQ(host.board().work_count(), worked) << death_ms;
  }
}

TEST(BjjczDriver, AListOutlastsNoPermission) {
  Host host(BjjczProfile(BJJCZ_LASER_UV));
  ASSERT_TRUE(host.Connect());
  ASSERT_TRUE(host.Run(Drawing()));
  ASSERT_TRUE(host.Until([&] { return host.board().lit(); }));
  host.permits = false;
  host.StepFor(250ms);
  const auto lists = host.board().lists_executed();
  host.StepFor(20ms);
  EXPECT_FALSE(host.board().lit());
  EXPECT_LE(host.board().lists_executed(), lists + 1);  // the empty one of the stop
  EXPECT_TRUE(host.settled());
}

// At any instant at most one mark is broken, none is made twice, and what the driver
// calls not begun has left nothing.
TEST(BjjczDriver, WhatALostLineLeavesIsOneMark) {
  const mark::MarkSet set = Drawing();
  for (int cut_ms = 1; cut_ms < 900; cut_ms += 23) {
    Host host(BjjczProfile(BJJCZ_LASER_FIBRE));
    ASSERT_TRUE(host.Connect());
    const auto power_up = host.driver().state().power_up;
    ASSERT_TRUE(host.Run(set));
    host.StepFor(std::chrono::milliseconds(cut_ms));
    host.machine().Cut(true);
    host.StepFor(1s);
    EXPECT_FALSE(host.driver().state().link_up);
    host.machine().Cut(false);
    ASSERT_TRUE(host.settled()) << cut_ms;
    EXPECT_NE(host.driver().state().power_up, power_up);
    mark::MarkSet made{set.pens, {}};
    int broken = 0;
    for (std::uint32_t i = 0; i < set.marks.size(); ++i) {
      broken += host.fates.contains(i) && host.fates[i] == MarkFate::kBroken ? 1 : 0;
      if (host.fates[i] != MarkFate::kNotBegun) made.marks.push_back(set.marks[i]);
    }
    EXPECT_LE(broken, 1) << cut_ms;
    const Lit lit = LitOf(made, host.board().strokes());
    EXPECT_LE(lit.largest_error_mm, 1.21 / kPlacesPerMm) << cut_ms;
    EXPECT_LE(lit.length_mm, LengthOfAll(made) + 0.02) << cut_ms;
  }
}

TEST(BjjczDriver, SetsOutputsByPermissionAndRun) {
  const BjjczBoard board = BjjczProfile(BJJCZ_LASER_UV).bjjcz_board();
  Host host(BjjczProfile(BJJCZ_LASER_UV));
  host.permits = false;
  ASSERT_TRUE(host.Connect());
  host.StepFor(50ms);
  EXPECT_EQ(host.board().outputs(), 0);
  host.permits = true;
  host.StepFor(50ms);
  EXPECT_EQ(host.board().outputs(), 1U << board.gate_output());
  ASSERT_TRUE(host.Run(Drawing()));
  host.StepFor(50ms);
  EXPECT_EQ(host.board().outputs(),
            1U << board.gate_output() | 1U << board.lamp_output());
  host.board().SetInput(kBjjczDoorInput, false);
  host.StepFor(60ms);
  EXPECT_EQ(host.board().outputs(), 0);
}

// Planted: another output switches the guide laser, in a run or while it is permitted.
TEST(BjjczDriver, AGuideLaserThatShinesByItselfIsFoundByTheSuite) {
  const auto& checks = MarkChecks();
  const auto guide = std::ranges::find(checks, "K12_guide", &MarkCheck::name);
  ASSERT_NE(guide, checks.end());
  const BjjczBoard board = BjjczProfile(BJJCZ_LASER_UV).bjjcz_board();
  for (const std::uint32_t output : {board.lamp_output(), board.gate_output()}) {
    MachineSpec profile = BjjczProfile(BJJCZ_LASER_UV);
    profile.mutable_bjjcz_board()->set_guide_output(output);
    const MarkRigMaker make = [&](const std::string&) {
      return MakeBjjczMarkRigOf(profile);
    };
    EXPECT_EQ(ViolationOf(*guide, make), "K12: the guide laser is on") << output;
  }
}

// Planted: the output that is switched on for an outline is that of the gate.
TEST(BjjczDriver, AnOutlineThatRaisesTheGateIsFoundByTheSuite) {
  const auto& checks = MarkChecks();
  const auto outline = std::ranges::find(checks, "K12_outline", &MarkCheck::name);
  ASSERT_NE(outline, checks.end());
  MachineSpec profile = BjjczProfile(BJJCZ_LASER_UV);
  profile.mutable_bjjcz_board()->set_guide_output(profile.bjjcz_board().gate_output());
  const MarkRigMaker make = [&](const std::string&) {
    return MakeBjjczMarkRigOf(profile);
  };
  EXPECT_EQ(ViolationOf(*outline, make),
            "K12: the gate of the laser is open in an outline");
}

// The field has 65 nodes: version 2 of the files, with a step at two nodes.
std::string CorFile(const std::string& folder, double scale) {
  std::string bytes(36 + 65 * 65 * 8 + 4, '\0');
  const std::string title = "JCZ_COR_2_1";
  for (std::size_t i = 0; i < title.size(); ++i) bytes[2 * i] = title[i];
  std::memcpy(bytes.data() + 28, &scale, sizeof scale);
  const std::int32_t first[2] = {12, -34};
  std::memcpy(bytes.data() + 36, first, sizeof first);
  const std::int32_t last[2] = {-1, 300};
  std::memcpy(bytes.data() + 36 + (65 * 65 - 1) * 8, last, sizeof last);
  std::ofstream(folder + "/field.cor", std::ios::binary) << bytes;
  return folder + "/field.cor";
}

TEST(BjjczDriver, UploadsACorrection) {
  MachineSpec profile = BjjczProfile(BJJCZ_LASER_FIBRE);
  profile.mutable_scan_head()->set_correction_file(
      CorFile(test::FreshFolder().string(), 65536.0 / 100));
  ASSERT_TRUE(CheckBjjczProfile(profile).empty());
  Host host(profile);
  ASSERT_TRUE(host.Connect());
  const auto& lines = host.board().correction();
  ASSERT_EQ(lines.size(), 65U * 65U);
  EXPECT_EQ(lines.front(), (std::array<std::uint16_t, 2>{12, 0x8000 + 34}));
  EXPECT_EQ(lines.back(), (std::array<std::uint16_t, 2>{0x8001, 300}));
  profile.mutable_scan_head()->set_field_mm(110);
  ASSERT_EQ(CheckBjjczProfile(profile).size(), 1U);
  EXPECT_TRUE(
      CheckBjjczProfile(profile)[0].message.starts_with("scan_head.field_mm: 110"));
}

TEST(BjjczDriver, RefusesWhatABoardCannot) {
  Host host(BjjczProfile(BJJCZ_LASER_FIBRE));
  ASSERT_TRUE(host.Connect());
  mark::MarkSet set = Drawing();
  set.pens[0].frequency_hz = 100;
  auto refused = host.Run(set);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("a frequency of 100 Hz"), std::string::npos);
  set = Drawing();
  set.pens[0].speed_mm_s = 1;
  refused = host.Run(set);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("a speed of 1 mm/s"), std::string::npos);
  set = Drawing();
  set.marks[0].places[0].at_mm = Vec2(51, 0);
  refused = host.Run(set);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("outside the field"), std::string::npos);
  set = Drawing();
  set.marks[0] = {0, false, 0, {{{0, 0}}, {{1, 0}, 0, true}, {{2, 0}}, {{3, 0}}}};
  Host another(BjjczProfile(BJJCZ_LASER_FIBRE));
  ASSERT_TRUE(another.Connect());
  refused = another.Run(set);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("mark 0: is a row of dots"), std::string::npos);
}

TEST(BjjczProfile, NamesEachField) {
  const auto first_error = [](const std::function<void(MachineSpec&)>& change) {
    MachineSpec profile = BjjczProfile(BJJCZ_LASER_UV);
    change(profile);
    const auto errors = CheckBjjczProfile(profile);
    return errors.empty() ? "" : errors.front().message;
  };
  EXPECT_EQ(first_error([](MachineSpec&) {}), "");
  const auto names = [&](const char* field, const std::function<void(MachineSpec&)>& to) {
    EXPECT_TRUE(first_error(to).starts_with(field)) << field << ": " << first_error(to);
  };
  names("bjjcz_board:", [](MachineSpec& m) { m.clear_bjjcz_board(); });
  names("bjjcz_board.laser",
        [](MachineSpec& m) { m.mutable_bjjcz_board()->clear_laser(); });
  names("bjjcz_board.door_input",
        [](MachineSpec& m) { m.mutable_bjjcz_board()->clear_door_input(); });
  names("bjjcz_board.gate_output",
        [](MachineSpec& m) { m.mutable_bjjcz_board()->set_lamp_output(0); });
  names("bjjcz_board.pulse_width_ns",
        [](MachineSpec& m) { m.mutable_bjjcz_board()->set_pulse_width_ns(20); });
  names("scan_head.field_mm",
        [](MachineSpec& m) { m.mutable_scan_head()->clear_field_mm(); });
  names("scan_head.jump_mm_s",
        [](MachineSpec& m) { m.mutable_scan_head()->set_jump_mm_s(500); });
  names("scan_head.servo_lag_s",
        [](MachineSpec& m) { m.mutable_scan_head()->set_servo_lag_s(0.0002); });
}

TEST(LmcProtocol, HasTheBytesOfABoard) {
  std::string bytes;
  AppendCommand({LmcOperation::kStandby, {2000, 20}}, bytes);
  EXPECT_EQ(bytes, std::string("\x1D\x00\xD0\x07\x14\x00\x00\x00\x00\x00\x00\x00", 12));
  bytes.clear();
  const LmcCommand jump{LmcOperation::kJump, {0x8001, 0x7FFF, 0, 1}};
  AppendPacket({&jump, 1}, bytes);
  ASSERT_EQ(bytes.size(), 3072U);
  EXPECT_EQ(bytes.substr(0, 12),
            std::string("\x01\x80\x01\x80\xFF\x7F\x00\x00\x01\x00\x00\x00", 12));
  for (std::size_t at = 12; at < bytes.size(); at += 12)
    ASSERT_EQ(bytes.substr(at, 12), "\x02\x80" + std::string(10, '\0')) << at;
  EXPECT_EQ(SignedNumber(5), 5);
  EXPECT_EQ(SignedNumber(-5), 0x8005);
  EXPECT_EQ(SignedNumber(-40000), 0xFFFF);
}

TEST(LmcProtocol, PutsAnswersTogether) {
  LmcReplyReader reader;
  const std::string bytes("\x00\x00\x08\x00\x00\x00\x24\x00\x01", 9);
  for (const char& byte : bytes) reader.Feed(std::as_bytes(std::span(&byte, 1)));
  const auto reply = reader.Next();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->numbers[1], 8);
  EXPECT_TRUE(reply->is_busy() && reply->is_ready());
  EXPECT_FALSE(reader.Next());
}

}  // namespace
}  // namespace intaglio::drivers
