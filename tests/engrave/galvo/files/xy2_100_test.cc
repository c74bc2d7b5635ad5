// XY2-100 frames as captured from real lines, and captures decoded as a head reads them.

#include "engrave/galvo/files/xy2_100.h"

#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "tests/test_folder.h"

namespace intaglio::galvo {
namespace {

struct Frame {
  std::uint32_t x = 0, y = 0;
  bool laser = false;
};

/// Bits at the falling edges of CLK; a frame ends with the bit in which SYNC is low.
std::vector<Frame> Decode(const std::string& capture) {
  std::istringstream in(capture);
  std::map<char, bool> level;
  std::vector<Frame> frames;
  Frame frame;
  int bits = 0;
  bool header = true;
  for (std::string line; std::getline(in, line);) {
    if (line == "$enddefinitions $end") header = false;
    if (header || line.size() != 2 || line[0] == '#') continue;
    level[line[1]] = line[0] == '1';
    if (line != "0c") continue;
    frame.x = frame.x << 1 | level['x'];
    frame.y = frame.y << 1 | level['y'];
    frame.laser = level['l'];
    ++bits;
    if (level['s']) continue;
    EXPECT_EQ(bits, 20);
    frames.push_back(frame);
    frame = {};
    bits = 0;
  }
  EXPECT_EQ(bits, 0) << "the last frame is not whole";
  return frames;
}

TEST(Xy2Frame, IsThatOfCapturedLines) {
  EXPECT_EQ(Xy2Frame(32768), 0x30000U);
  EXPECT_EQ(Xy2Frame(41017), 0x34073U);
  EXPECT_EQ(Xy2Frame(46087), 0x3680EU);
}

TEST(Xy2Frame, OfEachPositionIsReadAgainAndOneWrongBitIsSeen) {
  for (std::uint32_t position = 0; position < 65536; ++position) {
    const std::uint32_t frame = Xy2Frame(static_cast<std::uint16_t>(position));
    ASSERT_EQ(ReadXy2Frame(frame).value(), position);
    if (position % 97 != 0) continue;
    for (int bit = 0; bit < 20; ++bit)
      ASSERT_FALSE(ReadXy2Frame(frame ^ (1U << bit)).has_value()) << position;
  }
  EXPECT_EQ(ReadXy2Frame(0x30001).error().message,
            "the XY2-100 frame 30001h has an odd number of ones; check the line");
  EXPECT_FALSE(ReadXy2Frame(0x130000).has_value());
}

const std::vector<HeadOutput> kOutputs = {{32768, 32768, false},
                                          {41017, 46087, false},
                                          {46087, 41017, true},
                                          {0, 65535, false}};

TEST(Xy2Capture, IsDecodedAsAHeadReadsIt) {
  const std::vector<Frame> frames = Decode(WriteXy2Capture(kOutputs).value());
  ASSERT_EQ(frames.size(), kOutputs.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(ReadXy2Frame(frames[i].x).value(), kOutputs[i].x);
    EXPECT_EQ(ReadXy2Frame(frames[i].y).value(), kOutputs[i].y);
    EXPECT_EQ(frames[i].laser, kOutputs[i].laser);
  }
}

TEST(Xy2Capture, IsTheRecordedOne) {
  const std::string golden =
      test::ContentOf(INTAGLIO_SOURCE_DIR "/tests/data/galvo/xy2_100.vcd");
  EXPECT_EQ(WriteXy2Capture(kOutputs).value(), golden);
  // Independent of the writer: 4 frames of 10 us in steps of 250 ns.
  EXPECT_TRUE(golden.ends_with("#160\n"));
  EXPECT_EQ(Decode(golden).at(1).x, 0x34073U);
  EXPECT_EQ(Decode(golden).at(1).y, 0x3680EU);
}

TEST(Xy2Capture, RefusesMoreThanACaptureHolds) {
  const std::vector<HeadOutput> many(kMaxXy2Frames + 1);
  EXPECT_EQ(WriteXy2Capture(many).error().message,
            "200001 frames are more than the 200000 of a capture; write a part");
}

}  // namespace
}  // namespace intaglio::galvo
