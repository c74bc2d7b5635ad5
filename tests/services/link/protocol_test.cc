// Both protocols against their golden bytes, and against payloads that lie.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>

#include "tests/services/link/sample_frames.h"

namespace intaglio::link {
namespace {

using ::testing::HasSubstr;

std::string Hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

// The bytes on the wire are a contract with machines that are already installed: this
// file changes only together with the version of the frame.
TEST(Protocols, AreTheGoldenBytes) {
  std::ifstream file(INTAGLIO_SOURCE_DIR "/tests/data/link_frames.golden");
  std::map<std::string, std::string> golden;
  for (std::string name, hex; file >> name >> hex;) golden[name] = hex;
  for (const SampleFrame& sample : SampleFrames()) {
    EXPECT_EQ(golden[sample.name], Hex(Framed(sample))) << sample.name;
  }
  EXPECT_EQ(golden.size(), SampleFrames().size());
}

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

const std::map<std::string, Taker> kTakers = {{"LampCommand", Taken<LampCommand>},
                                              {"ShutterCommand", Taken<ShutterCommand>},
                                              {"ArmWindow", Taken<ArmWindow>},
                                              {"LaserIdentity", Taken<LaserIdentity>},
                                              {"LaserStatus", Taken<LaserStatus>},
                                              {"PulseReport", Taken<PulseReport>},
                                              {"BeginRun", Taken<BeginRun>},
                                              {"Segments", Taken<Segments>},
                                              {"MotionIdentity", Taken<MotionIdentity>},
                                              {"MotionStatus", Taken<MotionStatus>},
                                              {"Positions", Taken<Positions>}};

TEST(Protocols, EveryMessageWithAPayloadIsTakenWholeAndOnlyWhole) {
  std::size_t tried = 0;
  for (const SampleFrame& sample : SampleFrames()) {
    if (sample.payload.empty()) continue;
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
  EXPECT_FALSE(Taken<ShutterCommand>(Encode(ShutterCommand{0x10})));
  EXPECT_FALSE(Taken<ArmWindow>(Encode(ArmWindow{1, true, {}})));
  EXPECT_FALSE(Taken<ArmWindow>(Changed(Encode(ArmWindow{1, true, {true}}), 8, 2)));
  EXPECT_FALSE(Taken<ArmWindow>(
      Encode(ArmWindow{1, true, std::vector<bool>(kMaxArmTicks + 1, true)})));
  EXPECT_FALSE(Taken<LaserIdentity>(Encode(LaserIdentity{1, true, 0, {}, ""})));
  EXPECT_FALSE(Taken<LaserIdentity>(Encode(LaserIdentity{1, true, 5, {}, ""})));
  EXPECT_FALSE(Taken<PulseReport>(Encode(PulseReport{1, {static_cast<TickOutcome>(8)}})));
  EXPECT_FALSE(Taken<PulseReport>(Encode(PulseReport{1, {}})));
  const Segments one{1, 0, {WireSegment{1, 2, 3, 4, 5, 6, 7, false, false}}};
  EXPECT_TRUE(Taken<Segments>(Encode(one)));
  Segments still = one;
  still.segments[0].duration_subticks = 0;
  EXPECT_FALSE(Taken<Segments>(Encode(still)));
  EXPECT_FALSE(Taken<Segments>(Changed(Encode(one), Encode(one).size() - 1, 4)));
  EXPECT_FALSE(Taken<Positions>(Encode(Positions{1, 1, {}})));
}

TEST(Protocols, TheLongestMessagesFitInAFrame) {
  EXPECT_LE(Encode(ArmWindow{1, true, std::vector<bool>(kMaxArmTicks)}).size(),
            kMaxPayload);
  EXPECT_LE(Encode(PulseReport{1, std::vector<TickOutcome>(kMaxReportTicks)}).size(),
            kMaxPayload);
  EXPECT_LE(Encode(Segments{1, 1, std::vector<WireSegment>(kMaxSegments)}).size(),
            kMaxPayload);
  EXPECT_LE(
      Encode(Positions{1, 1, std::vector<Positions::Position>(kMaxPositions)}).size(),
      kMaxPayload);
}

}  // namespace
}  // namespace intaglio::link
