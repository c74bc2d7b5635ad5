// The frames against their golden bytes, those of the version before, and the document.

#include "tests/services/platform/link/golden_frames.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace intaglio::link {
namespace {

bool IsByte(const std::string& word) {
  return word.size() == 2 && word.find_first_not_of("0123456789abcdef") == word.npos;
}

// The bytes on the wire are a contract with machines that are already installed: this
// file changes only together with the version of the frame.
TEST(Protocols, AreTheGoldenBytes) {
  const auto golden = Golden();
  ASSERT_EQ(golden.size(), SampleFrames().size());
  for (const SampleFrame& sample : SampleFrames()) {
    EXPECT_EQ(golden.at(sample.name), Hex(Framed(sample))) << sample.name;
    EXPECT_EQ(PayloadOf(sample.name), sample.payload) << sample.name;
  }
}

// A machine that was not upgraded: nothing of it is understood as something else.
TEST(Protocols, DropEachFrameOfTheVersionBefore) {
  const auto before = Golden("link_frames_version_12.golden");
  ASSERT_FALSE(before.empty());
  for (const auto& [name, hex] : before) {
    FrameParser().Feed(BytesOf(hex), [&name](const FrameHeader&, auto) {
      ADD_FAILURE() << name << " is taken";
    });
  }
}

TEST(Protocols, TheExampleOfTheDocumentIsAGoldenFrame) {
  std::ifstream file(INTAGLIO_SOURCE_DIR "/docs/protocols.md");
  std::string line, hex;
  while (std::getline(file, line) && !line.starts_with("Example, LampCommand")) {
  }
  std::getline(file, line);
  // Bytes first, in pairs of digits, then what they are.
  while (std::getline(file, line) && line != "```") {
    std::istringstream words(line);
    for (std::string word; words >> word && IsByte(word);) hex += word;
  }
  EXPECT_EQ(hex, Golden().at("LampCommand"));
}

}  // namespace
}  // namespace intaglio::link
