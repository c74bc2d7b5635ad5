#include "services/virtual_engraver/laser.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

namespace intaglio::virtual_engraver {
namespace {

using link::TickOutcome;

LaserOptions Quick() {
  LaserOptions options;
  options.rates_hz = {100, 200};
  options.warm_up_s = 0.045;  // warm at the fifth tick of 10 ms
  options.channels = 4;
  options.min_energy_mj = 0;  // windows without an energy fire
  return options;
}

/// Warm, all interlocks closed, channels 1 and 3 open.
Laser ReadyLaser() {
  Laser laser(Quick());
  laser.SetLamp({true, 100});
  for (int i = 0; i < 10; ++i) laser.AdvanceTick(false);
  laser.SetShutters(0b0101);
  return laser;
}

link::ArmWindow FireAt(std::uint64_t tick, bool gated = false) {
  return {tick, gated, {true}};
}

std::map<std::uint64_t, TickOutcome> OutcomesOf(Laser& laser) {
  std::map<std::uint64_t, TickOutcome> outcomes;
  for (const link::PulseReport& report : laser.TakeReports()) {
    for (std::size_t i = 0; i < report.outcome.size(); ++i) {
      EXPECT_TRUE(outcomes.emplace(report.first_tick + i, report.outcome[i]).second);
    }
  }
  return outcomes;
}

/// Everything a pulse needs, each given or not.
struct Givens {
  bool armed, in_position, key, door, stop_released, no_safe_state, lamp_on, lamp_warm,
      shutter_open;
};
constexpr unsigned kGivens = 9;

Givens GivensOfBits(unsigned bits) {
  const auto bit = [bits](int i) { return (bits >> i & 1u) != 0; };
  return {bit(0), bit(1), bit(2), bit(3), bit(4), bit(5), bit(6), bit(7), bit(8)};
}

/// Brings a laser to the eve of tick 7 with what is given, and passes that tick.
std::uint8_t PulseAtTickSeven(Laser& laser, const Givens& given, bool gated) {
  if (given.lamp_warm) laser.SetLamp({true, 100});
  for (int i = 0; i < 6; ++i) laser.AdvanceTick(false);
  laser.SetLamp({given.lamp_on, 100});
  if (given.shutter_open) laser.SetShutters(0b0010);
  if (given.armed) laser.Decide(FireAt(7, gated));
  laser.SetKey(given.key);
  laser.SetDoor(given.door);
  if (!given.stop_released) laser.SetStopButton(true);
  if (!given.no_safe_state) laser.EnterSafeState();
  return laser.AdvanceTick(given.in_position);
}

TEST(Laser, APulseComesOutExactlyWhenEverythingIsGiven) {
  for (const bool gated : {false, true}) {
    int pulses = 0;
    for (unsigned bits = 0; bits < 1u << kGivens; ++bits) {
      const Givens g = GivensOfBits(bits);
      const bool all = g.armed && (g.in_position || !gated) && g.key && g.door &&
                       g.stop_released && g.no_safe_state && g.lamp_on && g.lamp_warm &&
                       g.shutter_open;
      Laser laser(Quick());
      const std::uint8_t channels = PulseAtTickSeven(laser, g, gated);
      EXPECT_EQ(channels, all ? 0b0010 : 0) << gated << " " << bits;
      EXPECT_EQ(laser.Report().pulse_count, all ? 1u : 0u) << gated << " " << bits;
      pulses += channels != 0;
    }
    EXPECT_EQ(pulses, gated ? 1 : 2);
  }
}

TEST(Laser, ReportsTheFirstThingThatIsMissing) {
  struct Case {
    unsigned missing_bit;
    TickOutcome outcome;
  };
  for (const Case& c :
       {Case{1, TickOutcome::kNotInPosition}, Case{2, TickOutcome::kInterlocked},
        Case{3, TickOutcome::kInterlocked}, Case{6, TickOutcome::kLampNotReady},
        Case{7, TickOutcome::kLampNotReady}, Case{8, TickOutcome::kShutterClosed}}) {
    Laser laser(Quick());
    const Givens given = GivensOfBits(((1u << kGivens) - 1) & ~(1u << c.missing_bit));
    PulseAtTickSeven(laser, given, true);
    const auto outcomes = OutcomesOf(laser);
    ASSERT_EQ(outcomes.size(), 1u) << c.missing_bit;
    EXPECT_EQ(outcomes.at(7), c.outcome) << c.missing_bit;
  }
}

TEST(Laser, StatusNamesEveryInterlock) {
  Laser laser(Quick());
  EXPECT_EQ(laser.Report().interlocks,
            link::kKeyOn | link::kDoorClosed | link::kStopReleased);
  laser.SetLamp({true, 100});
  laser.AdvanceTick(false);
  EXPECT_EQ(laser.Report().interlocks & (link::kLampOn | link::kLampWarm), link::kLampOn);
  EXPECT_NEAR(laser.Report().warm_ratio, 0.01 / 0.045, 1e-12);
  for (int i = 0; i < 4; ++i) laser.AdvanceTick(false);
  EXPECT_NE(laser.Report().interlocks & link::kLampWarm, 0);
  EXPECT_EQ(laser.Report().warm_ratio, 1);
  laser.SetKey(false);
  laser.SetDoor(false);
  laser.SetStopButton(true);
  EXPECT_EQ(laser.Report().interlocks,
            link::kLampOn | link::kLampWarm | link::kSafeState);
}

TEST(Laser, EmergencyStopStaysUntilItsReset) {
  for (const bool by_button : {true, false}) {
    Laser laser = ReadyLaser();
    laser.Decide({11, false, std::vector<bool>(50, true)});
    EXPECT_NE(laser.AdvanceTick(false), 0);
    if (by_button) {
      laser.SetStopButton(true);
      laser.Reset();  // still pressed: no reset
      EXPECT_EQ(laser.Report().interlocks & link::kStopReleased, 0);
      laser.SetStopButton(false);
    } else {
      laser.Stop();
    }
    EXPECT_EQ(laser.shutters(), 0);
    EXPECT_FALSE(laser.NextIsDecided());
    EXPECT_EQ(laser.Report().interlocks & link::kStopReleased, 0) << "latched";
    laser.SetShutters(0b1111);
    laser.Decide({laser.tick() + 1, false, {true, true}});
    EXPECT_EQ(laser.shutters(), 0) << "no shutter opens in the safe state";
    EXPECT_EQ(laser.AdvanceTick(true), 0);

    laser.Reset();
    EXPECT_EQ(laser.Report().interlocks & (link::kStopReleased | link::kSafeState),
              link::kStopReleased);
    EXPECT_EQ(laser.shutters(), 0) << "shutters stay closed until they are told";
    laser.SetShutters(1);
    EXPECT_EQ(laser.AdvanceTick(true), 0) << "what was armed before is forgotten";
    laser.Decide(FireAt(laser.tick() + 1));
    EXPECT_EQ(laser.AdvanceTick(false), 1);
  }
}

TEST(Laser, LampOffForgetsItsWarmth) {
  Laser laser = ReadyLaser();
  laser.SetLamp({false, 100});
  laser.SetLamp({true, 100});
  laser.Decide({11, false, std::vector<bool>(8, true)});
  int first_pulse = 0;
  for (int i = 1; i <= 8 && first_pulse == 0; ++i) {
    if (laser.AdvanceTick(false) != 0) first_pulse = i;
  }
  EXPECT_EQ(first_pulse, 5);
  laser.SetLamp({true, 200});
  EXPECT_EQ(laser.Report().warm_ratio, 1) << "another rate keeps the lamp warm";
}

TEST(Laser, TakesOnlyItsOwnRates) {
  Laser laser = ReadyLaser();
  laser.SetLamp({true, 150});
  laser.AdvanceTick(false);
  EXPECT_EQ(laser.rate_hz(), 100);
  laser.SetLamp({true, 200});
  laser.AdvanceTick(false);
  EXPECT_EQ(laser.rate_hz(), 200);
  const std::uint64_t before_us = laser.Report().machine_us;
  for (int i = 0; i < 10; ++i) laser.AdvanceTick(false);
  EXPECT_NEAR(static_cast<double>(laser.Report().machine_us - before_us), 50000, 1);
}

TEST(Laser, OnlyChannelsThatAreBuiltInOpen) {
  LaserOptions options = Quick();
  options.channels = 2;
  Laser laser(options);
  laser.SetShutters(0b1111);
  EXPECT_EQ(laser.shutters(), 0b0011);
}

TEST(Laser, CountsPulsesAndNamesTheLast) {
  Laser laser = ReadyLaser();
  const std::vector<bool> fire = {true, false, true, true, false, false, true, false};
  laser.Decide({11, false, fire});
  for (std::size_t i = 0; i < fire.size(); ++i)
    EXPECT_EQ(laser.AdvanceTick(false) != 0, fire[i]) << i;
  EXPECT_EQ(laser.Report().pulse_count, 4u);
  EXPECT_EQ(laser.Report().last_fired_tick, 17u);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(laser.AdvanceTick(true), 0) << "not decided";
  EXPECT_EQ(laser.Report().pulse_count, 4u);
}

TEST(Laser, AMissedPulseIsFiredButUnseen) {
  Laser laser = ReadyLaser();
  laser.Decide({11, false, {true, true, false}});
  laser.AdvanceTick(false);
  laser.Missed(0x0f);
  laser.AdvanceTick(false);
  laser.AdvanceTick(false);
  const std::map<std::uint64_t, TickOutcome> expected = {{11, TickOutcome::kFiredUnseen},
                                                         {12, TickOutcome::kFiredSeen},
                                                         {13, TickOutcome::kNotArmed}};
  EXPECT_EQ(OutcomesOf(laser), expected);
  EXPECT_EQ(laser.Report().pulse_count, 2u);
}

TEST(Laser, AWithheldPulseIsNoneAndIsNotCounted) {
  Laser laser = ReadyLaser();
  laser.Decide({11, false, {true, true}});
  ASSERT_NE(laser.AdvanceTick(false), 0);
  const link::LaserStatus fired = laser.Report();
  ASSERT_NE(laser.AdvanceTick(false), 0);
  laser.Withhold();
  EXPECT_EQ(laser.Report().pulse_count, fired.pulse_count);
  EXPECT_EQ(laser.Report().last_fired_tick, 11u);
  EXPECT_EQ(laser.made_pulse_count(), 1u);
  EXPECT_EQ(laser.Past({12, 1}).outcome, std::vector{TickOutcome::kTriggerOutside});
  const std::map<std::uint64_t, TickOutcome> expected = {
      {11, TickOutcome::kFiredSeen}, {12, TickOutcome::kTriggerOutside}};
  EXPECT_EQ(OutcomesOf(laser), expected);
}

TEST(Laser, WithoutPhotosensorsNoChannelIsNamed) {
  Laser laser = ReadyLaser();
  laser.Decide(FireAt(11));
  laser.AdvanceTick(false);
  laser.Unseen();
  EXPECT_EQ(laser.Past({11, 1}).outcome, std::vector{TickOutcome::kFiredUnseen});
  const auto reports = laser.TakeReports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].outcome, std::vector{TickOutcome::kFiredUnseen});
  EXPECT_EQ(reports[0].missed, std::vector<std::uint8_t>{0});
}

TEST(Laser, WhatItHasNotItDoesNotOfferAndDoesNotDo) {
  LaserOptions options = Quick();
  options.fires_at_place = options.measures_energy = false;
  Laser laser(options);
  EXPECT_FALSE(laser.Identity().fires_at_place);
  laser.SetLamp({true, 100});
  for (int i = 0; i < 10; ++i) laser.AdvanceTick(false);
  laser.SetShutters(1);
  link::ArmWindow at_place = FireAt(11, true);
  at_place.at_place = true;
  laser.Decide(at_place);
  laser.Decide(FireAt(12));
  EXPECT_EQ(laser.AdvanceTick(true), 0);
  EXPECT_EQ(laser.AdvanceTick(true), 1);
  const auto reports = laser.TakeReports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].measured_mj, std::vector<float>(2, 0));
}

TEST(Laser, ReportsEveryDecidedTickOnceAndInOrder) {
  Laser laser = ReadyLaser();
  const std::vector<bool> fire(1000, true);
  laser.Decide({11, false, fire});
  laser.Decide({1011, false, fire});
  while (laser.tick() < 2010) laser.AdvanceTick(false);
  std::uint64_t next = 11;
  for (const link::PulseReport& report : laser.TakeReports()) {
    EXPECT_EQ(report.first_tick, next);
    ASSERT_LE(report.outcome.size(), link::kMaxReportTicks);
    next += report.outcome.size();
  }
  EXPECT_EQ(next, 2011u);
}

TEST(Laser, ADecidedTickIsNotDecidedAgain) {
  Laser laser = ReadyLaser();
  laser.Decide({11, false, {false, false, false}});
  laser.Decide({12, false, {true, true, true}});
  std::vector<std::uint64_t> fired;
  for (int i = 0; i < 6; ++i) {
    if (laser.AdvanceTick(false) != 0) fired.push_back(laser.tick());
  }
  EXPECT_EQ(fired, std::vector<std::uint64_t>{14});
}

TEST(Laser, ALatePulseIsReportedInAReportOfItsOwn) {
  Laser laser = ReadyLaser();  // at tick 10
  // Tick 9 and 10 have passed: 9 was to fire, 10 not, 11 and 12 come in time.
  laser.Decide({9, false, {true, false, true, true}});
  // The present tick has passed, too; what follows it follows in another report.
  laser.Decide(FireAt(10));
  laser.AdvanceTick(false);
  laser.AdvanceTick(false);
  const auto reports = laser.TakeReports();
  ASSERT_EQ(reports.size(), 3u);
  EXPECT_EQ(reports[0].first_tick, 9u);
  EXPECT_EQ(reports[0].outcome, std::vector{TickOutcome::kTooLate});
  EXPECT_EQ(reports[1].first_tick, 10u);
  EXPECT_EQ(reports[1].outcome, std::vector{TickOutcome::kTooLate});
  EXPECT_EQ(reports[2].first_tick, 11u);
  EXPECT_EQ(reports[2].outcome, std::vector(2, TickOutcome::kFiredSeen));
}

TEST(Laser, DisarmedTicksDoNotFireAndMayBeDecidedAnew) {
  Laser laser = ReadyLaser();
  laser.Decide({11, false, std::vector<bool>(10, true)});
  laser.AdvanceTick(false);
  laser.Disarm();
  EXPECT_FALSE(laser.NextIsDecided());
  EXPECT_EQ(laser.Report().decided_through, 11u);
  EXPECT_EQ(laser.Report().disarms_taken, 1u);
  EXPECT_EQ(laser.AdvanceTick(true), 0);
  laser.Decide(FireAt(13));
  EXPECT_NE(laser.AdvanceTick(false), 0);
}

TEST(Laser, ANewHostFindsNothingArmed) {
  Laser laser = ReadyLaser();
  laser.Decide({11, false, std::vector<bool>(10, true)});
  laser.AdvanceTick(false);
  laser.Disarm();
  laser.Decide({12, false, std::vector<bool>(10, true)});
  laser.NewSession();
  EXPECT_TRUE(laser.TakeReports().empty());
  EXPECT_EQ(laser.Report().disarms_taken, 0u);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(laser.AdvanceTick(true), 0);
  EXPECT_EQ(laser.Report().pulse_count, 1u) << "the counter is the machine's";
}

// The host that armed a tick may be dead when its outcome is asked for.
TEST(Laser, RemembersWhatCameOfEveryTickOverSessions) {
  Laser laser = ReadyLaser();  // at tick 10
  laser.Decide({11, false, {true, false, true, true}});
  laser.AdvanceTick(false);
  laser.AdvanceTick(false);
  laser.AdvanceTick(false);
  laser.Missed(0x0f);
  laser.NewSession();  // tick 14 is armed no longer
  laser.AdvanceTick(true);
  laser.Decide(FireAt(15));
  laser.Decide(FireAt(12));  // too late: that is not what came of tick 12
  laser.SetDoor(false);
  laser.AdvanceTick(false);
  laser.Decide(FireAt(16));  // to come
  const link::PastReport past = laser.Past({9, 9});
  EXPECT_EQ(past.first_tick, 9u);
  EXPECT_EQ(past.outcome, (std::vector{TickOutcome::kNotArmed, TickOutcome::kNotArmed,
                                       TickOutcome::kFiredSeen, TickOutcome::kNotArmed,
                                       TickOutcome::kFiredUnseen, TickOutcome::kNotArmed,
                                       TickOutcome::kInterlocked, TickOutcome::kNotArmed,
                                       TickOutcome::kNotArmed}));
}

TEST(Laser, RemembersTheNewestTicksAndReportsWhatItForgot) {
  Laser laser = ReadyLaser();
  laser.Decide({11, false, {true, true}});
  while (laser.tick() < 11 + link::kRememberedTicks) laser.AdvanceTick(false);
  EXPECT_EQ(laser.Past({11, 2}).outcome,
            (std::vector{TickOutcome::kNoLongerKnown, TickOutcome::kFiredSeen}));
  laser.AdvanceTick(false);
  EXPECT_EQ(laser.Past({12, 2}).outcome,
            (std::vector{TickOutcome::kNoLongerKnown, TickOutcome::kNotArmed}));
  const std::uint64_t end = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(laser.Past({end - 2, 2}).outcome, std::vector(2, TickOutcome::kNotArmed));
}

// However short, and whether or not anybody listens.
TEST(Laser, CountsHowOftenAnInterlockLetGo) {
  Laser laser = ReadyLaser();
  EXPECT_EQ(laser.Report().openings, 0u);
  laser.SetDoor(false);
  laser.SetDoor(false);
  laser.SetDoor(true);
  EXPECT_EQ(laser.Report().openings, 1u);
  laser.SetKey(false);
  laser.SetKey(true);
  laser.SetStopButton(true);
  laser.SetStopButton(false);
  laser.NewSession();
  laser.Stop();
  laser.Reset();
  EXPECT_EQ(laser.Report().openings, 3u);
}

// A host may send any number: a window at the end of the count must neither fire nor
// hang.
TEST(Laser, WildWindowsDoNothing) {
  Laser laser = ReadyLaser();
  const std::uint64_t end = std::numeric_limits<std::uint64_t>::max();
  laser.Decide({end, false, {true}});
  laser.Decide({end, false, std::vector<bool>(4096, true)});
  laser.Decide({end - 5, false, std::vector<bool>(4096, true)});
  laser.Decide({0, false, {}});
  for (int i = 0; i < 100; ++i) EXPECT_EQ(laser.AdvanceTick(true), 0);
  laser.Decide(FireAt(111));
  EXPECT_NE(laser.AdvanceTick(false), 0);
}

/// Outcome of one armed tick of a ready laser with this timing, and whether it fired.
std::pair<TickOutcome, bool> PulseWith(const link::PulseTiming& timing,
                                       const LaserSignals& signals,
                                       bool at_place = false) {
  LaserOptions options = Quick();
  options.signals = signals;
  Laser laser(options);
  laser.SetTiming(timing);
  laser.SetLamp({true, 100});
  for (int i = 0; i < 10; ++i) laser.AdvanceTick(false);
  laser.SetShutters(1);
  laser.Decide({11, true, {true}, at_place});
  const bool fired = laser.AdvanceTick(true) != 0;
  EXPECT_EQ(laser.Report().pulse_count, fired ? 1u : 0u);
  return {OutcomesOf(laser).at(11), fired};
}

// Trochimczuk 2008, annex D: within 20 us of the lamp sync, at least 100 us long.
TEST(LaserTrigger, OutsideItsTimesMakesNoPulseAndIsReported) {
  for (const double shift_us : {-100.0, -6.0, -5.0, 0.0, 14.9, 15.0, 15.1, 40.0, 500.0}) {
    LaserSignals shifted;
    shifted.trigger_shift_us = shift_us;
    const bool inside = 5 + shift_us >= 0 && 5 + shift_us <= 20;
    EXPECT_EQ(PulseWith({}, shifted),
              std::pair(inside ? TickOutcome::kFiredSeen : TickOutcome::kTriggerOutside,
                        inside))
        << shift_us;
    // The trigger of the compare output has no time from the lamp sync.
    EXPECT_TRUE(PulseWith({}, shifted, true).second) << shift_us;
    // The controller makes up for its cable.
    link::PulseTiming made_up;
    made_up.qswitch_delay_us = 10 - shift_us;
    if (made_up.qswitch_delay_us >= 0) {
      EXPECT_TRUE(PulseWith(made_up, shifted).second);
    }
  }
  for (const double width_us : {0.0, 50.0, 99.9, 100.0, 120.0, 1000.0}) {
    link::PulseTiming timing;
    timing.qswitch_width_us = width_us;
    EXPECT_EQ(PulseWith(timing, {}).second, width_us >= 100) << width_us;
    EXPECT_EQ(PulseWith(timing, {}, true).second, width_us >= 100) << width_us;
  }
}

TEST(LaserTrigger, AFlashIsSeenByASignalThatIsLongEnough) {
  for (const double width_us : {5.0, 10.0, 10.1, 25.0}) {
    LaserSignals signals;
    signals.sensor_width_us = width_us;
    EXPECT_EQ(PulseWith({}, signals).first,
              width_us > 10 ? TickOutcome::kFiredSeen : TickOutcome::kFiredUnseen)
        << width_us;
  }
}

TEST(LaserSync, ThatIsTooShortIsNotCounted) {
  LaserOptions options = Quick();
  for (const double width_us : {1.0, 2.0, 2.1, 5.0}) {
    options.signals.sync_width_us = width_us;
    const Laser laser(options);
    EXPECT_EQ(laser.CountsSync(), width_us > 2) << width_us;
    EXPECT_EQ((laser.Report().interlocks & link::kNoLampSync) != 0, width_us <= 2);
  }
}

/// Channels that get light at each of 12 armed ticks, channel 1 open; at the third tick
/// channel 2 takes its place.
std::vector<std::uint8_t> LightWhileShuttersChange(double waits_ms, double takes_ms,
                                                   std::vector<std::uint8_t>* reported) {
  LaserOptions options = Quick();
  options.signals.shutter_time_s = takes_ms / 1000;
  Laser laser(options);
  link::PulseTiming timing;
  timing.shutter_time_ms = waits_ms;
  laser.SetTiming(timing);
  laser.SetLamp({true, 100});
  laser.SetShutters(1);
  for (int i = 0; i < 20; ++i) laser.AdvanceTick(false);
  laser.Decide({21, false, std::vector<bool>(12, true)});
  std::vector<std::uint8_t> light;
  for (int i = 0; i < 12; ++i) {
    if (i == 3) laser.SetShutters(2);
    light.push_back(laser.AdvanceTick(false));
    reported->push_back(laser.Report().shutters_open);
  }
  return light;
}

// Ticks of 10 ms. Without the wait a shutter that closes for 35 ms lets three pulses into
// the block of its channel, and the first ones of the other are not whole.
TEST(LaserShutters, NoPulseWhileOneMoves) {
  using Masks = std::vector<std::uint8_t>;
  Masks reported;
  EXPECT_EQ(LightWhileShuttersChange(0, 35, &reported),
            (Masks{1, 1, 1, 3, 3, 3, 3, 2, 2, 2, 2, 2}));
  reported.clear();
  EXPECT_EQ(LightWhileShuttersChange(35, 35, &reported),
            (Masks{1, 1, 1, 0, 0, 0, 0, 2, 2, 2, 2, 2}));
  EXPECT_EQ(reported, (Masks{1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2}));
}

}  // namespace
}  // namespace intaglio::virtual_engraver
