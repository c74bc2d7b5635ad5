#include "services/recorder/sequence_gaps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

namespace intaglio::recorder {
namespace {

using Message = std::vector<std::byte>;

/// A message as the bus encodes it, and more behind its number.
class Encoded {
 public:
  Encoded(unsigned encoding, std::size_t max_alignment)
      : max_alignment_(max_alignment),
        bytes_{std::byte{}, std::byte(encoding), std::byte{}, std::byte{}} {}

  template <typename T>
  Encoded& Add(T number) {
    const std::size_t alignment = std::min(sizeof(T), max_alignment_);
    while ((bytes_.size() - 4) % alignment != 0) bytes_.emplace_back();
    const bool big = (static_cast<unsigned>(bytes_[1]) & 1) == 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const std::size_t at = big ? sizeof(T) - 1 - i : i;
      bytes_.push_back(std::byte(static_cast<unsigned char>(number >> (8 * at))));
    }
    return *this;
  }
  Encoded& Add(const std::string& text) {
    Add(static_cast<std::uint32_t>(text.size() + 1));
    for (const char c : text) bytes_.push_back(std::byte(c));
    bytes_.emplace_back();
    return *this;
  }
  Message Take() { return Add(std::uint64_t{77}).bytes_; }

 private:
  std::size_t max_alignment_;
  Message bytes_;
};

Message Outcome(const std::string& job, std::uint64_t number, unsigned encoding = 1,
                std::size_t max_alignment = 8) {
  return Encoded(encoding, max_alignment).Add(job).Add(number).Take();
}

constexpr std::string_view kOutcomes = "intaglio::PulseEventBatch";

TEST(SequenceGaps, AreCountedInEachStreamByItself) {
  SequenceGaps gaps;
  const auto before = [&](std::uint32_t channel, const std::string& job,
                          std::uint64_t number) {
    return gaps.Before(channel, kOutcomes, Outcome(job, number));
  };
  EXPECT_EQ(before(0, "a", 5), 0u) << "the recorder came later";
  EXPECT_EQ(before(0, "a", 6), 0u);
  EXPECT_EQ(before(0, "a", 9), 2u);
  EXPECT_EQ(before(0, "b", 0), 0u);
  EXPECT_EQ(before(1, "a", 12), 0u) << "of another cell";
  EXPECT_EQ(before(0, "a", 10), 0u);
  EXPECT_EQ(before(0, "b", 37'499), 37'498u);
  EXPECT_EQ(before(0, "a", 0), 0u) << "its writer began anew";
  EXPECT_EQ(before(0, "a", 2), 1u);
}

TEST(SequenceGaps, AreFoundInEveryEncoding) {
  const std::pair<unsigned, std::size_t> encodings[] = {{0, 8}, {1, 8}, {6, 4}, {7, 4}};
  for (const auto& [encoding, max_alignment] : encodings) {
    // Names of all lengths, for every alignment of what follows.
    for (const char* job : {"", "j", "jo", "job", "job7", "job78"}) {
      SequenceGaps gaps;
      const auto message = [&, encoding = encoding,
                            align = max_alignment](std::uint64_t number) {
        return Outcome(job, number, encoding, align);
      };
      EXPECT_EQ(gaps.Before(0, kOutcomes, message(1)), 0u);
      EXPECT_EQ(gaps.Before(0, kOutcomes, message(0x1'0000'0004)), 0x1'0000'0002u)
          << encoding << job;
    }
  }
  SequenceGaps gaps;
  const auto motion = [](std::uint32_t run, std::uint64_t number) {
    return Encoded(1, 8).Add(std::string("j")).Add(run).Add(number).Take();
  };
  EXPECT_EQ(gaps.Before(0, "intaglio::MotionSegmentBatch", motion(1, 4)), 0u);
  EXPECT_EQ(gaps.Before(0, "intaglio::MotionSegmentBatch", motion(2, 0)), 0u);
  EXPECT_EQ(gaps.Before(0, "intaglio::MotionSegmentBatch", motion(2, 2)), 1u);
}

TEST(SequenceGaps, WhatIsNoSuchMessageHasNone) {
  const Message whole = Outcome("job", 9);
  for (std::size_t size = 0; size < 20; ++size) {
    SequenceGaps gaps;
    EXPECT_EQ(gaps.Before(0, kOutcomes, Outcome("job", 1)), 0u);
    EXPECT_EQ(gaps.Before(0, kOutcomes, std::span(whole).first(size)), 0u) << size;
  }
  SequenceGaps gaps;
  EXPECT_EQ(gaps.Before(0, "intaglio::JobStatus", Outcome("job", 1)), 0u);
  EXPECT_EQ(gaps.Before(0, "intaglio::JobStatus", Outcome("job", 9)), 0u);
  Message huge = whole;
  std::fill_n(huge.begin() + 4, 4, std::byte{0xFF});  // the length of the name
  EXPECT_EQ(gaps.Before(0, kOutcomes, huge), 0u);
}

/// The members in front of sequence_number of the struct, as SequencedType has them; ""
/// when it has none.
std::string LeadingIn(const std::string& idl, const std::string& name) {
  const auto begin = idl.find("struct " + name + " {");
  if (begin == idl.npos) return "";
  std::istringstream words(idl.substr(begin, idl.find("};", begin) - begin));
  std::string line, leading;
  std::getline(words, line);
  while (std::getline(words, line)) {
    std::istringstream member(line);
    std::string type, field;
    member >> type >> field;
    if (field == "sequence_number;") return leading;
    leading += type == "string" ? 's' : type == "uint32" ? 'u' : '?';
  }
  return "";
}

// A type that changes, and this table does not, would have no gaps any more.
TEST(SequenceGaps, TypesAreThoseOfTheirFiles) {
  std::string idl;
  for (const auto& file :
       std::filesystem::directory_iterator(INTAGLIO_SOURCE_DIR "/idl")) {
    std::ifstream in(file.path());
    idl.append(std::istreambuf_iterator<char>(in), {});
  }
  for (const SequencedType& type : SequencedTypes()) {
    EXPECT_EQ(LeadingIn(idl, std::string(type.type.substr(10))), type.leading)
        << type.type;
  }
}

}  // namespace
}  // namespace intaglio::recorder
