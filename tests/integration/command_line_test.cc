// What a person sees who types the command: help everywhere, documentation that is true,
// and for bad input an exit code and a sentence to act on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "tests/integration/run_program.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using testing::FreshFolder;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;

Ended Type(const std::vector<std::string>& words) {
  const fs::path folder =
      FreshFolder(std::string("command_line_") +
                  ::testing::UnitTest::GetInstance()->current_test_info()->name());
  Running run(Program("intaglio"), words, folder / "output.txt");
  return run.WaitForEnd(30s);
}

std::string ReadText(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

const std::vector<std::string> kCommands = {
    "run",    "up",     "submit",     "list", "show",   "watch",  "arm",      "pause",
    "resume", "cancel", "discretize", "sort", "verify", "render", "materials"};

std::set<std::string> FlagsIn(const std::string& text) {
  std::set<std::string> flags;
  const std::regex flag("(^|[\\s`\"(,])(--[a-z][a-z-]*)");
  for (std::sregex_iterator at(text.begin(), text.end(), flag), end; at != end; ++at) {
    flags.insert((*at)[2]);
  }
  return flags;
}

TEST(CommandLine, TellsANewcomerWhatToDoNext) {
  for (const auto& words : std::vector<std::vector<std::string>>{{}, {"--help"}}) {
    const Ended ended = Type(words);
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_THAT(ended.output, HasSubstr("Where to begin"));
    EXPECT_THAT(ended.output, HasSubstr("intaglio run --mesh FILE"));
    for (const std::string& command : kCommands) {
      EXPECT_THAT(ended.output, HasSubstr("\n  " + command + " ")) << command;
    }
  }
}

TEST(CommandLine, EveryCommandHasHelpAndAPlaceInTheDocumentation) {
  const std::string document = ReadText(INTAGLIO_SOURCE_DIR "/docs/cli.md") +
                               ReadText(INTAGLIO_SOURCE_DIR "/docs/materials.md");
  const std::set<std::string> documented = FlagsIn(document);
  std::set<std::string> known = {"--help"};
  for (const std::string& command : kCommands) {
    const Ended ended = Type({command, "--help"});
    EXPECT_EQ(ended.exit_code, 0) << command;
    EXPECT_THAT(document, HasSubstr(command));
    for (const std::string& flag : FlagsIn(ended.output)) {
      known.insert(flag);
      EXPECT_TRUE(flag == "--help" || documented.contains(flag))
          << command << " " << flag;
    }
  }
  // And nothing is documented that is not there.
  for (const std::string& flag : FlagsIn(ReadText(INTAGLIO_SOURCE_DIR "/docs/cli.md"))) {
    EXPECT_TRUE(known.contains(flag)) << flag;
  }
}

TEST(CommandLine, AMistypedCommandOrOptionIsWrongInput) {
  EXPECT_EQ(Type({"engrave"}).exit_code, 2);
  EXPECT_EQ(Type({"run", "--hight", "40"}).exit_code, 2);
  const Ended both = Type({"run", "--mesh", "a.stl", "--height", "1", "--size", "2"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.output, HasSubstr("--size"));
}

TEST(CommandLine, WithoutAShopAJobCommandSaysHowToStartOne) {
  const Ended ended = Type({"show", "1", "--domain", "97", "--tag", "nobody"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_TRUE(ended.in_time);
  EXPECT_THAT(ended.output, HasSubstr("intaglio up"));
}

// Files that broke other programs.
TEST(CommandLine, BrokenModelsAreNamedWithARemedyAndNothingIsMade) {
  const fs::path broken = INTAGLIO_SOURCE_DIR "/../shared/data/broken";
  if (!fs::exists(broken)) GTEST_SKIP() << "no " << broken;
  std::size_t tried = 0;
  for (const fs::path& file : fs::directory_iterator(broken)) {
    if (file.filename() == "busted.STL") continue;  // a sound surface without normals
    ++tried;
    const fs::path out = FreshFolder("command_line_broken") / "cloud.ply";
    const Ended ended = Type(
        {"discretize", "--mesh", file.string(), "--height", "20", "--out", out.string()});
    EXPECT_EQ(ended.exit_code, 2) << file;
    EXPECT_TRUE(ended.in_time);
    EXPECT_THAT(ended.output, HasSubstr(file.filename().string()));
    EXPECT_FALSE(fs::exists(out));
  }
  EXPECT_GT(tried, 4u);
}

TEST(CommandLine, AnUnknownGlassIsAnsweredWithNamesThatAreNear) {
  const Ended shown = Type({"materials", "show", "NBK7"});
  EXPECT_EQ(shown.exit_code, 2);
  EXPECT_THAT(shown.output, HasSubstr("N-BK7"));
}

}  // namespace
}  // namespace intaglio
