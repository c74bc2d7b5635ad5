#include "services/platform/link/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string_view>

#include "engrave/core/check.h"
#include "tests/services/platform/link/sample_frames.h"

namespace intaglio::link {
namespace {

// CRC-32 bit by bit, from its polynomial alone.
std::uint32_t SlowCrc(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const std::byte byte : bytes) {
    crc ^= static_cast<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB88320 : 0);
  }
  return ~crc;
}

struct Received {
  FrameHeader header;
  Bytes payload;
};

std::vector<Received> Parse(FrameParser& parser, std::span<const std::byte> bytes) {
  std::vector<Received> frames;
  parser.Feed(bytes, [&](const FrameHeader& header, std::span<const std::byte> payload) {
    frames.push_back({header, Bytes(payload.begin(), payload.end())});
  });
  return frames;
}

std::vector<Received> Parse(std::span<const std::byte> bytes) {
  FrameParser parser;
  return Parse(parser, bytes);
}

TEST(Frame, ComesBackAsItWent) {
  for (const SampleFrame& sample : SampleFrames()) {
    const auto frames = Parse(Framed(sample));
    ASSERT_EQ(frames.size(), 1u) << sample.name;
    EXPECT_EQ(frames[0].header.type, sample.type);
    EXPECT_EQ(frames[0].header.session, 0xDEADBEEFu);
    EXPECT_EQ(frames[0].header.acknowledged, 6);
    EXPECT_EQ(frames[0].header.credit, 256);
    EXPECT_EQ(frames[0].payload, sample.payload);
  }
}

TEST(Frame, EndsWithTheCrcOfItsPolynomial) {
  const std::string_view check = "123456789";
  ASSERT_EQ(SlowCrc(std::as_bytes(std::span(check))), 0xCBF43926u);  // published
  const Bytes bytes = Framed(SampleFrames()[6]);
  const std::uint32_t crc = SlowCrc(std::span(bytes).subspan(2, bytes.size() - 6));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(static_cast<std::uint32_t>(bytes[bytes.size() - 4 + i]),
              crc >> (8 * i) & 0xff);
  }
}

TEST(Frame, WithOneBitTurnedIsNotDelivered) {
  for (const SampleFrame& sample : SampleFrames()) {
    const Bytes bytes = Framed(sample);
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      Bytes damaged = bytes;
      damaged[bit / 8] ^= std::byte(1 << (bit % 8));
      EXPECT_TRUE(Parse(damaged).empty()) << sample.name << " bit " << bit;
    }
  }
}

TEST(Frame, CutShortIsNotDeliveredAndTheNextOneIs) {
  for (const SampleFrame& sample : SampleFrames()) {
    const Bytes whole = Framed(sample);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      // The first byte of the next one is the last that it lacks.
      if (size + 1 == whole.size() && whole.back() == whole.front()) continue;
      const auto cut = std::span(whole).first(size);
      FrameParser parser;
      EXPECT_TRUE(Parse(parser, cut).empty()) << sample.name << " cut at " << size;
      EXPECT_EQ(Parse(parser, whole).size(), 1u) << sample.name << " cut at " << size;
      EXPECT_EQ(parser.dropped_bytes(), size);
    }
  }
}

// The length is the one field that can make the next frame wait.
TEST(Frame, WithADamagedLengthDoesNotHoldUpTheNextOne) {
  for (const SampleFrame& sample : SampleFrames()) {
    const Bytes whole = Framed(sample);
    for (int length = 0; length < 0x10000; length += 7) {
      Bytes damaged = whole;
      damaged[14] = std::byte(length & 0xff);
      damaged[15] = std::byte(length >> 8);
      if (damaged == whole) continue;
      FrameParser parser;
      EXPECT_TRUE(Parse(parser, damaged).empty()) << sample.name << " length " << length;
      EXPECT_EQ(Parse(parser, whole).size(), 1u) << sample.name << " length " << length;
    }
  }
}

TEST(Frame, ArrivesByteByByteBetweenNoise) {
  std::mt19937_64 random(1);
  FrameParser parser;
  std::size_t delivered = 0;
  const auto samples = SampleFrames();
  for (int i = 0; i < 500; ++i) {
    Bytes line;
    for (std::uint64_t n = random() % 30; n > 0; --n) line.push_back(std::byte(random()));
    const Bytes frame = Framed(samples[i % samples.size()]);
    line.insert(line.end(), frame.begin(), frame.end());
    for (const std::byte byte : line) delivered += Parse(parser, {&byte, 1}).size();
    ASSERT_EQ(delivered, static_cast<std::size_t>(i + 1));
  }
  EXPECT_GT(parser.dropped_bytes(), 0u);
}

TEST(Frame, TooLongAPayloadThrows) {
  Bytes out;
  EXPECT_THROW(AppendFrame({}, Bytes(kMaxPayload + 1), out), PreconditionError);
}

}  // namespace
}  // namespace intaglio::link
