#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "services/cell/manual/manual_control.h"
#include "services/cli/intaglio_program.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;

constexpr double kLapseS = std::chrono::duration<double>(cell::kInterlockTime).count();
constexpr double kFastestMmS = cell::ManualControl::kMaxSpeedMmS;

TEST(TeachHelp, StatesTheWayThatAMotionGoesOnWithoutReportsAsTheCellBoundsIt) {
  for (const char* const order : {"jog", "move", "to-zero"}) {
    std::vector<std::string> words{"intaglio", "teach", order, "--help"};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    ::testing::internal::CaptureStdout();
    EXPECT_EQ(IntaglioProgram()->Parse(static_cast<int>(argv.size()), argv.data()), 0);
    std::istringstream lines(::testing::internal::GetCapturedStdout());
    std::string text;
    for (std::string word; lines >> word;) text += word + " ";
    EXPECT_THAT(text, HasSubstr(fmt::format("mm/s, at most {:g};", kFastestMmS)));
    EXPECT_THAT(text, HasSubstr(fmt::format("after {:g} s of it", kLapseS)));
    EXPECT_THAT(text, HasSubstr(fmt::format("{:g} mm and that at {:g} mm/s",
                                            kLapseS * kFastestMmS, kFastestMmS)));
  }
}

TEST(TeachHelp, IsWhatTheDocumentHas) {
  std::ifstream file(INTAGLIO_SOURCE_DIR "/docs/cli.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(text, HasSubstr(fmt::format("[after {:g} s of it](machines/teach.md"
                                          "#motion-by-hand), {:g} mm at {:g} mm/s",
                                          kLapseS, kLapseS * kFastestMmS, kFastestMmS)));
}

}  // namespace
}  // namespace intaglio::cli
