// The protocols against their golden bytes, and against payloads that lie.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>

#include "tests/services/platform/link/golden_frames.h"
#include "tests/services/platform/link/sample_frames.h"

namespace intaglio::link {
namespace {

using ::testing::HasSubstr;

/// Whether a message's payload is taken, and gives the same bytes again.
template <typename T>
bool Taken(std::span<const std::byte> payload) {
  const auto message = Decode<T>(payload);
  if (!message) {
    EXPECT_EQ(message.error().code, ErrorCode::kUnreadable);
    EXPECT_THAT(message.error().message, HasSubstr("malformed"));
    return false;
  }
  const Bytes again = Encode(*message);
  EXPECT_EQ(Hex(payload), Hex(again));
  return true;
}

using Taker = bool (*)(std::span<const std::byte>);

const std::map<std::string, Taker> kTakers = {
    {"LampCommand", Taken<LampCommand>},
    {"ShutterCommand", Taken<ShutterCommand>},
    {"ArmWindow", Taken<ArmWindow>},
    {"LaserIdentity", Taken<LaserIdentity>},
    {"LaserStatus", Taken<LaserStatus>},
    {"PulseReport", Taken<PulseReport>},
    {"PastRequest", Taken<PastRequest>},
    {"PastReport", Taken<PastReport>},
    {"PulseTiming", Taken<PulseTiming>},
    {"AccessoryCommand", Taken<AccessoryCommand>},
    {"AccessoryState", Taken<AccessoryState>},
    {"BeginRun", Taken<BeginRun>},
    {"Segments", Taken<Segments>},
    {"MotionIdentity", Taken<MotionIdentity>},
    {"MotionStatus", Taken<MotionStatus>},
    {"Positions", Taken<Positions>},
    {"BeginTimedRun", Taken<BeginTimedRun>},
    {"TimedSegments", Taken<TimedSegments>},
    {"TimedPositions", Taken<TimedPositions>},
    {"ControllerClock", Taken<ControllerClock>},
    {"StageTolerance", Taken<StageTolerance>},
    {"StageSpeed", Taken<StageSpeed>},
    {"JogMove", Taken<JogMove>},
    {"MoveBlock", Taken<MoveBlock>},
    {"HeadPermit", Taken<HeadPermit>},
    {"HeadBegin", Taken<HeadBegin>},
    {"HeadBlock", Taken<HeadBlock>},
    {"HeadPastRequest", Taken<HeadPastRequest>},
    {"HeadIdentity", Taken<HeadIdentity>},
    {"HeadStatus", Taken<HeadStatus>},
    {"HeadMarks", Taken<HeadMarks>},
    {"HeadWeb", Taken<HeadWeb>},
    {"HeadPrint", Taken<HeadPrint>},
    {"HeadPast", Taken<HeadPast>}};

TEST(Protocols, EveryMessageWithAPayloadIsTakenWholeAndOnlyWhole) {
  std::size_t tried = 0;
  for (const SampleFrame& sample : SampleFrames()) {
    // Those below 0x10 are the session's own: line_epoch_test.cc.
    if (sample.payload.empty() || sample.type < 0x10) continue;
    const Taker taken = kTakers.at(sample.name);
    ++tried;
    EXPECT_TRUE(taken(sample.payload)) << sample.name;
    for (std::size_t size = 0; size < sample.payload.size(); ++size) {
      EXPECT_FALSE(taken(std::span(sample.payload).first(size))) << sample.name;
    }
    Bytes longer = sample.payload;
    longer.push_back({});
    EXPECT_FALSE(taken(longer)) << sample.name;
  }
  EXPECT_EQ(tried, kTakers.size());
}

Bytes Changed(Bytes payload, std::size_t at, std::uint8_t value) {
  payload.at(at) = std::byte(value);
  return payload;
}

TEST(Protocols, ValuesOutOfRangeAreRefused) {
  EXPECT_FALSE(Taken<LampCommand>(Changed(Encode(LampCommand{true, 100}), 0, 2)));
  EXPECT_FALSE(Taken<LampCommand>(Encode(LampCommand{true, std::nan("")})));
  EXPECT_FALSE(Taken<LampCommand>(Encode(LampCommand{true, INFINITY})));
  EXPECT_FALSE(Taken<LampCommand>(Encode(LampCommand{true, -1})));
  EXPECT_FALSE(Taken<ShutterCommand>(Encode(ShutterCommand{0x10})));
  EXPECT_FALSE(Taken<ArmWindow>(Encode(ArmWindow{1, true, {}})));
  EXPECT_TRUE(Taken<ArmWindow>(Encode(ArmWindow{1, true, {true}, true})));
  EXPECT_FALSE(Taken<ArmWindow>(Changed(Encode(ArmWindow{1, true, {true}}), 8, 2)))
      << "at a place without the gate";
  EXPECT_FALSE(Taken<ArmWindow>(Changed(Encode(ArmWindow{1, true, {true}}), 8, 4)));
  EXPECT_FALSE(Taken<ArmWindow>(
      Encode(ArmWindow{1, true, std::vector<bool>(kMaxArmTicks + 1, true)})));
  EXPECT_FALSE(Taken<LaserIdentity>(Encode(LaserIdentity{1, true, 0, {}, ""})));
  EXPECT_FALSE(Taken<LaserIdentity>(Encode(LaserIdentity{1, true, 5, {}, ""})));
  EXPECT_FALSE(Taken<LaserIdentity>(Encode(LaserIdentity{1, true, 1, {0}, ""})));
  EXPECT_FALSE(Taken<LaserIdentity>(Encode(LaserIdentity{1, true, 1, {NAN}, ""})));
  // What an identity offers: no bit that this version does not know.
  const Bytes offers = Encode(LaserIdentity{1, true, 1, {100}, ""});
  EXPECT_TRUE(Taken<LaserIdentity>(Changed(offers, 17, 3)));
  EXPECT_FALSE(Taken<LaserIdentity>(Changed(offers, 17, 4)));
  EXPECT_FALSE(Taken<PulseReport>(Encode(PulseReport{1, {static_cast<TickOutcome>(8)}})));
  EXPECT_FALSE(Taken<PulseReport>(Encode(PulseReport{1, {}})));
  EXPECT_FALSE(
      Taken<PulseReport>(Encode(PulseReport{1, {static_cast<TickOutcome>(11)}})));
  EXPECT_FALSE(Taken<PulseReport>(
      Changed(Encode(PulseReport{1, {TickOutcome::kFiredSeen}}), 10, 0x11)))
      << "a channel of a pulse that was seen missed";
  const auto measured = [](float mj) {
    return Taken<PulseReport>(
        Encode(PulseReport{1, {TickOutcome::kFiredSeen}, {0}, {mj}}));
  };
  EXPECT_TRUE(measured(10000));
  EXPECT_FALSE(measured(10001));
  EXPECT_FALSE(measured(-1));
  EXPECT_FALSE(measured(NAN));
  EXPECT_FALSE(Taken<PastReport>(Encode(PastReport{1, {static_cast<TickOutcome>(7)}})));
  EXPECT_FALSE(Taken<PastReport>(Encode(PastReport{1, {static_cast<TickOutcome>(11)}})));
  EXPECT_TRUE(Taken<PulseTiming>(Encode(PulseTiming{0, 10000, 0, 10000, 1000})));
  EXPECT_FALSE(Taken<PulseTiming>(Encode(PulseTiming{-0.1, 120, 2, 10, 0})));
  EXPECT_FALSE(Taken<PulseTiming>(Encode(PulseTiming{5, 10001, 2, 10, 0})));
  EXPECT_FALSE(Taken<PulseTiming>(Encode(PulseTiming{5, 120, NAN, 10, 0})));
  EXPECT_FALSE(Taken<PulseTiming>(Encode(PulseTiming{5, 120, 2, INFINITY, 0})));
  EXPECT_FALSE(Taken<PulseTiming>(Encode(PulseTiming{5, 120, 2, 10, 1001})));
  const auto heights = [](double min_mm, double max_mm) {
    return Taken<PulseTiming>(Encode(PulseTiming{5, 120, 2, 10, 0, min_mm, max_mm}));
  };
  EXPECT_TRUE(heights(-10000, 10000));
  EXPECT_FALSE(heights(1, 0));
  EXPECT_FALSE(heights(-10001, 0));
  EXPECT_FALSE(heights(NAN, 0));
  EXPECT_FALSE(heights(0, INFINITY));
  const auto energy = [](double mj) {
    return Taken<ArmWindow>(Encode(ArmWindow{1, true, {true}, false, mj}));
  };
  EXPECT_TRUE(energy(0)) << "which no laser has in its range";
  EXPECT_TRUE(energy(10000));
  EXPECT_FALSE(energy(10001));
  EXPECT_FALSE(energy(-1));
  EXPECT_FALSE(energy(NAN));
  const auto range = [](double min_mj, double max_mj) {
    return Taken<LaserIdentity>(
        Encode(LaserIdentity{1, true, 1, {100}, "", "", true, min_mj, max_mj}));
  };
  EXPECT_TRUE(range(30, 30));
  EXPECT_FALSE(range(30, 29));
  EXPECT_FALSE(range(NAN, 30));
  EXPECT_FALSE(range(0, INFINITY));
  EXPECT_FALSE(Taken<PastReport>(Encode(PastReport{1, {}})));
  EXPECT_FALSE(Taken<PastReport>(
      Encode(PastReport{1, std::vector<TickOutcome>(kMaxPastTicks + 1)})));
  EXPECT_FALSE(Taken<PastRequest>(Encode(PastRequest{1, 0})));
  EXPECT_FALSE(Taken<PastRequest>(Encode(PastRequest{1, kMaxPastTicks + 1})));
  const Segments one{1, 0, {WireSegment{1, 2, 3, 4, 5, 6, 7, false, false}}};
  EXPECT_TRUE(Taken<Segments>(Encode(one)));
  Segments still = one;
  still.segments[0].duration_subticks = 0;
  EXPECT_FALSE(Taken<Segments>(Encode(still)));
  EXPECT_FALSE(Taken<Segments>(Changed(Encode(one), Encode(one).size() - 1, 4)));
  EXPECT_FALSE(Taken<Positions>(Encode(Positions{1, 1, {}})));
  EXPECT_FALSE(Taken<TimedPositions>(Encode(TimedPositions{1, 1, {}})));
  EXPECT_FALSE(Taken<ControllerClock>(Encode(ControllerClock{0, 1})));
  EXPECT_FALSE(Taken<StageTolerance>(Encode(StageTolerance{0})));
  EXPECT_FALSE(Taken<StageSpeed>(Encode(StageSpeed{1, 1, 0})));
  EXPECT_FALSE(Taken<AccessoryCommand>(Encode(AccessoryCommand{0, 1, 2})));
  EXPECT_FALSE(Taken<AccessoryState>(Encode(AccessoryState{9, 0, 0, 0})));
  EXPECT_FALSE(Taken<AccessoryState>(Encode(AccessoryState{0, 9, 0, 0})));
  EXPECT_FALSE(Taken<AccessoryState>(Encode(AccessoryState{2, 0, 4, 0})));
  EXPECT_FALSE(Taken<AccessoryState>(Encode(AccessoryState{0, 2, 0, 4})));
  TimedSegments two{
      1, 0, {{1, 2, 3, 4, 5, 6, 7, false, false}, {1, 2, 3, 4, 5, 6, 8, false, false}}};
  EXPECT_TRUE(Taken<TimedSegments>(Encode(two)));
  two.segments[1].end_ns = 7;  // takes no time
  EXPECT_FALSE(Taken<TimedSegments>(Encode(two)));
  two.segments[0].end_ns = 0;
  EXPECT_FALSE(Taken<TimedSegments>(Encode(two)));
}

TEST(Protocols, AStatusOutOfRangeIsRefused) {
  const auto changed = [](auto field, auto value) {
    LaserStatus status;
    status.*field = value;
    return Encode(status);
  };
  EXPECT_TRUE(Taken<LaserStatus>(changed(&LaserStatus::warm_ratio, 1.0)));
  EXPECT_FALSE(Taken<LaserStatus>(changed(&LaserStatus::warm_ratio, 1.01)));
  EXPECT_FALSE(Taken<LaserStatus>(changed(&LaserStatus::warm_ratio, -0.01)));
  EXPECT_FALSE(Taken<LaserStatus>(changed(&LaserStatus::warm_ratio, NAN)));
  EXPECT_FALSE(Taken<LaserStatus>(changed(&LaserStatus::rate_hz, -1.0)));
  EXPECT_FALSE(Taken<LaserStatus>(changed(&LaserStatus::rate_hz, INFINITY)));
  EXPECT_FALSE(Taken<LaserStatus>(changed(&LaserStatus::shutters_open, 0x10)));
  MotionStatus fault;
  fault.fault = static_cast<StageFault>(18);
  EXPECT_FALSE(Taken<MotionStatus>(Encode(fault)));
  EXPECT_TRUE(Taken<MotionStatus>(Changed(Encode(MotionStatus{}), 56, 0x1f)));
  EXPECT_FALSE(Taken<MotionStatus>(Changed(Encode(MotionStatus{}), 56, 0x20)));
}

template <typename Identity>
Bytes WithSerialNumber(const std::string& text) {
  Identity identity;
  identity.serial_number = text;
  return Encode(identity);
}

/// A payload that ends with a serial number of 64 characters, made 65 long by hand.
Bytes OneLonger(Bytes payload) {
  payload.at(payload.size() - 65) = std::byte{65};
  payload.push_back(std::byte{'x'});
  return payload;
}

template <typename Identity>
void CheckSerialNumbers() {
  for (const std::string& text :
       {std::string(), std::string("A-03"), std::string(" ~"), std::string(64, 'x')}) {
    const auto read = Decode<Identity>(WithSerialNumber<Identity>(text));
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(read->serial_number, text);
  }
  // The sender cuts what is too long, a receiver refuses it.
  const Bytes longest = WithSerialNumber<Identity>(std::string(65, 'x'));
  EXPECT_EQ(longest, WithSerialNumber<Identity>(std::string(64, 'x')));
  EXPECT_FALSE(Taken<Identity>(OneLonger(longest)));
  for (const char c : {'\0', '\n', '\x1b', '\x7f', '\x80', '\xff'})
    EXPECT_FALSE(Taken<Identity>(WithSerialNumber<Identity>(std::string("A") + c)));
}

TEST(Protocols, SerialNumbersArePrintableAndOfAtMost64Characters) {
  CheckSerialNumbers<LaserIdentity>();
  CheckSerialNumbers<MotionIdentity>();
}

// Version 7 had no energies: a window of its length fires nothing.
TEST(Protocols, AWindowWithoutTheEnergyIsRefused) {
  Bytes window = Encode(ArmWindow{1, true, {true}, false, 30});
  window.erase(window.begin() + 11, window.begin() + 19);
  EXPECT_FALSE(Taken<ArmWindow>(window));
}

TEST(Protocols, AWindowWithoutThePulsesOfAPointIsRefused) {
  ArmWindow window{1, true, {true}, false, 30, kMaxPulsesPerPoint};
  Bytes bytes = Encode(window);
  EXPECT_TRUE(Taken<ArmWindow>(bytes));
  bytes.erase(bytes.begin() + 19, bytes.begin() + 21);
  ++window.pulses_per_point;
  EXPECT_FALSE(Taken<ArmWindow>(bytes) || Taken<ArmWindow>(Encode(window)));
}

// Version 4 of the frames had none: such a payload is too short now.
TEST(Protocols, AnIdentityWithoutTheFieldOfThePlaceIsRefused) {
  Bytes laser = Encode(LaserIdentity{1, true, 1, {100}, "old"});
  laser.pop_back();
  EXPECT_FALSE(Taken<LaserIdentity>(laser));
  Bytes motion = Encode(MotionIdentity{{0, 0, 0}, {1, 1, 1}, 7});
  motion.pop_back();
  EXPECT_FALSE(Taken<MotionIdentity>(motion));
}

// One payload, one meaning: bits behind the last tick are zero.
TEST(Protocols, UnusedBitsOfAWindowAreRefused) {
  const Bytes window = Encode(ArmWindow{1, true, std::vector<bool>(9, true)});
  EXPECT_TRUE(Taken<ArmWindow>(window));
  EXPECT_FALSE(Taken<ArmWindow>(Changed(window, window.size() - 1, 0x03)));
}

// Ticks of a message whose last one is past 2^64 would compare as the past.
TEST(Protocols, TicksThatGoRoundAreRefused) {
  constexpr std::uint64_t kEnd = std::numeric_limits<std::uint64_t>::max();
  const std::vector<bool> fire(4, true);
  EXPECT_TRUE(Taken<ArmWindow>(Encode(ArmWindow{kEnd - 4, true, fire})));
  EXPECT_FALSE(Taken<ArmWindow>(Encode(ArmWindow{kEnd - 3, true, fire})));
  const std::vector<TickOutcome> outcome(4);
  EXPECT_TRUE(Taken<PulseReport>(Encode(PulseReport{kEnd - 4, outcome})));
  EXPECT_FALSE(Taken<PulseReport>(Encode(PulseReport{kEnd - 3, outcome})));
  EXPECT_TRUE(Taken<PastReport>(Encode(PastReport{kEnd - 4, outcome})));
  EXPECT_FALSE(Taken<PastReport>(Encode(PastReport{kEnd - 3, outcome})));
  EXPECT_TRUE(Taken<PastRequest>(Encode(PastRequest{kEnd - 4, 4})));
  EXPECT_FALSE(Taken<PastRequest>(Encode(PastRequest{kEnd - 3, 4})));
  const std::vector<Positions::Position> positions(4);
  EXPECT_TRUE(Taken<Positions>(Encode(Positions{1, kEnd - 4, positions})));
  EXPECT_FALSE(Taken<Positions>(Encode(Positions{1, kEnd - 3, positions})));
  const std::vector<TimedPositions::Position> stamped(4);
  EXPECT_TRUE(Taken<TimedPositions>(Encode(TimedPositions{1, kEnd - 4, stamped})));
  EXPECT_FALSE(Taken<TimedPositions>(Encode(TimedPositions{1, kEnd - 3, stamped})));
  const Segments numbered{1, kEnd, {WireSegment{1, 2, 3, 4, 5, 6, 7, false, false}}};
  EXPECT_FALSE(Taken<Segments>(Encode(numbered)));
}

TEST(Protocols, AFileOfGoldenBytesIsReadAsTheMessagesItHolds) {
  const auto window = Decode<ArmWindow>(PayloadOf("ArmWindow"));
  ASSERT_TRUE(window);
  EXPECT_EQ(window->first_tick, 4711u);
  EXPECT_TRUE(window->gated);
  EXPECT_FALSE(window->at_place);
  EXPECT_EQ(window->fire, (std::vector<bool>{1, 0, 0, 1, 0, 0, 0, 0, 1}));
  EXPECT_EQ(window->pulse_energy_mj, 12.5);
  const auto report = Decode<PulseReport>(PayloadOf("PulseReport"));
  ASSERT_TRUE(report);
  EXPECT_EQ(report->outcome[2], TickOutcome::kFiredUnseen);
  EXPECT_EQ(report->missed, (std::vector<std::uint8_t>{0, 0, 5, 0}));
  EXPECT_EQ(report->measured_mj, (std::vector<float>{12.25F, 0, 12.75F, 0}));
  const auto past = Decode<PastReport>(PayloadOf("PastReport"));
  ASSERT_TRUE(past);
  EXPECT_EQ(past->missed, (std::vector<std::uint8_t>{0, 8, 0}));
  const auto accessories = Decode<AccessoryCommand>(PayloadOf("AccessoryCommand"));
  ASSERT_TRUE(accessories);
  EXPECT_EQ(accessories->on, 5);
  EXPECT_EQ(accessories->watched, 0x83);
  EXPECT_EQ(accessories->levels, 0x81);
  const auto state = Decode<AccessoryState>(PayloadOf("AccessoryState"));
  ASSERT_TRUE(state);
  EXPECT_EQ(*state, (AccessoryState{3, 8, 0x05, 0x81}));
  const auto identity = Decode<LaserIdentity>(PayloadOf("LaserIdentity"));
  ASSERT_TRUE(identity);
  EXPECT_EQ(identity->rates_hz, (std::vector<double>{50, 100}));
  EXPECT_EQ(identity->model, "virtual");
  EXPECT_EQ(identity->serial_number, "A-03");
  EXPECT_TRUE(identity->fires_at_place);
  EXPECT_TRUE(identity->locks_door);
  EXPECT_EQ(identity->min_energy_mj, 0.5);
  EXPECT_EQ(identity->max_energy_mj, 30);
  const auto stage_identity = Decode<MotionIdentity>(PayloadOf("MotionIdentity"));
  ASSERT_TRUE(stage_identity);
  EXPECT_EQ(stage_identity->queue_capacity, 4096u);
  EXPECT_EQ(stage_identity->serial_number, "ST 7/2");
  EXPECT_TRUE(stage_identity->compares_place);
  EXPECT_TRUE(stage_identity->watches_air);
  const auto tolerance = Decode<StageTolerance>(PayloadOf("StageTolerance"));
  ASSERT_TRUE(tolerance);
  EXPECT_EQ(tolerance->position_nm, 30000u);
  const auto speed = Decode<StageSpeed>(PayloadOf("StageSpeed"));
  ASSERT_TRUE(speed);
  EXPECT_EQ(speed->z_counts, 40000000u);
  const auto status = Decode<LaserStatus>(PayloadOf("LaserStatus"));
  ASSERT_TRUE(status);
  EXPECT_EQ(status->machine_us, 47200000u);
  EXPECT_EQ(status->interlocks, 0x9f);
  EXPECT_EQ(status->disarms_taken, 2u);
  EXPECT_EQ(status->openings, 7u);
  const auto segments = Decode<Segments>(PayloadOf("Segments"));
  ASSERT_TRUE(segments);
  ASSERT_EQ(segments->segments.size(), 2u);
  EXPECT_EQ(segments->segments[0].y_nm, -2500000);
  EXPECT_EQ(segments->segments[0].vz_counts, 100000000);
  EXPECT_TRUE(segments->segments[0].pulse);
  EXPECT_EQ(segments->segments[1].duration_subticks, 98304u);
  EXPECT_TRUE(segments->segments[1].program_end);
  const auto stage = Decode<MotionStatus>(PayloadOf("MotionStatus"));
  ASSERT_TRUE(stage);
  EXPECT_EQ(stage->vy_counts, -5);
  EXPECT_EQ(stage->segments_taken, 96u);
  EXPECT_EQ(stage->fault, StageFault::kFollowingError);
  EXPECT_EQ(stage->following_error_max_nm, 12345u);
}

TEST(Protocols, TheLongestMessagesFitInAFrame) {
  EXPECT_LE(Encode(ArmWindow{1, true, std::vector<bool>(kMaxArmTicks)}).size(),
            kMaxPayload);
  const std::vector fired(kMaxReportTicks, TickOutcome::kFiredSeen);
  EXPECT_LE(Encode(PulseReport{1, fired}).size(), kMaxPayload);
  EXPECT_LE(Encode(PastReport{1, std::vector<TickOutcome>(kMaxPastTicks)}).size(),
            kMaxPayload);
  EXPECT_LE(Encode(Segments{1, 1, std::vector<WireSegment>(kMaxSegments)}).size(),
            kMaxPayload);
  EXPECT_LE(
      Encode(Positions{1, 1, std::vector<Positions::Position>(kMaxPositions)}).size(),
      kMaxPayload);
}

}  // namespace
}  // namespace intaglio::link
