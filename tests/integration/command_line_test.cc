// What a person sees who types the command: help everywhere, documentation that is true,
// and for bad input an exit code and a sentence to act on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <regex>
#include <set>

#include "services/client/exit_codes.h"
#include "tests/engrave/discretize/figurines.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::Running;
using testing::TextIn;

Ended Type(const std::vector<std::string>& words) {
  const fs::path folder = test::FreshFolder();
  // Not the materials base of the user who runs the tests.
  setenv("INTAGLIO_MATERIALS_DB", (folder / "materials.db").c_str(), 1);
  Running run(Program("intaglio"), words, folder / "output.txt");
  return run.WaitForEnd(30s);
}

const std::vector<std::string> kCommands = {
    "run",      "up",     "submit", "list",       "show",    "watch",  "arm",
    "pause",    "resume", "cancel", "discretize", "sort",    "plan",   "post",
    "measure",  "verify", "render", "materials",  "history", "batch",  "again",
    "security", "stop",   "record", "recording",  "replay",  "help",   "preview",
    "fonts",    "status", "course", "mount",      "backup",  "restore"};

std::set<std::string> FlagsIn(const std::string& text) {
  std::set<std::string> flags;
  const std::regex flag("(^|[\\s`\"(,])(--[a-z][a-z-]*)");
  for (std::sregex_iterator at(text.begin(), text.end(), flag), end; at != end; ++at) {
    flags.insert((*at)[2]);
  }
  return flags;
}

TEST(CommandLine, ShowsANewcomerWhatToDoNext) {
  for (const auto& words : std::vector<std::vector<std::string>>{{}, {"--help"}}) {
    const Ended ended = Type(words);
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_THAT(ended.output, HasSubstr("Where to begin"));
    EXPECT_THAT(ended.output, HasSubstr("intaglio run FILE"));
    for (const std::string& command : kCommands) {
      EXPECT_THAT(ended.output, HasSubstr("\n  " + command + " ")) << command;
    }
  }
}

TEST(CommandLine, HelpOfACommandIsThatOfItsOption) {
  const Ended help = Type({"help", "recording", "cut"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.output, HasSubstr("Usage: intaglio recording cut"));
  EXPECT_EQ(Type({"recording", "cut", "--help"}).output, help.output);
  EXPECT_EQ(Type({"help", "recrod"}).exit_code, 2);
}

TEST(CommandLine, TheServicesTooAreDocumentedAsTheyAre) {
  const std::set<std::string> documented =
      FlagsIn(TextIn(INTAGLIO_SOURCE_DIR "/docs/services.md"));
  std::set<std::string> known;
  for (const char* command : {"history", "submit", "up"}) {  // of the examples
    known.merge(FlagsIn(Type({command, "--help"}).output));
  }
  for (const char* program :
       {"intaglio-job-service", "intaglio-discretizer", "intaglio-sorter",
        "intaglio-synchronizer", "intaglio-motion-bridge", "intaglio-marker",
        "intaglio-recorder", "intaglio-console", "intaglio-reference-controller",
        "virtual-engraver"}) {
    Running run(Program(program), {"--help"},
                test::FreshFolder("command_line_services") / "output.txt");
    const Ended ended = run.WaitForEnd(30s);
    EXPECT_EQ(ended.exit_code, 0) << program;
    for (const std::string& flag : FlagsIn(ended.output)) {
      known.insert(flag);
      EXPECT_TRUE(flag == "--help" || flag == "--version" || documented.contains(flag))
          << program << " " << flag;
    }
  }
  for (const std::string& flag : documented) EXPECT_TRUE(known.contains(flag)) << flag;
}

TEST(CommandLine, AMistypedCommandOrOptionIsWrongInput) {
  EXPECT_EQ(Type({"engrave"}).exit_code, 2);
  EXPECT_EQ(Type({"run", "--hight", "40"}).exit_code, 2);
  const Ended both = Type({"run", "--mesh", "a.stl", "--height", "1", "--size", "2"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.output, HasSubstr("--size"));
}

TEST(CommandLine, WithoutAShopAJobCommandNamesTheRemedy) {
  const Ended ended = Type({"show", "1", "--domain", "97", "--tag", "nobody"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_TRUE(ended.in_time);
  EXPECT_THAT(ended.output, HasSubstr("intaglio up"));
}

// Files that broke other programs.
TEST(CommandLine, BrokenModelsAreNamedWithARemedyAndNothingIsMade) {
  const fs::path broken = INTAGLIO_SOURCE_DIR "/tests/data/broken";
  std::size_t tried = 0;
  for (const fs::path& file : fs::directory_iterator(broken)) {
    // The lines of an open drawing are engraved; other tests have what is reported of it.
    if (file.extension() == ".dxf") continue;
    ++tried;
    const fs::path out = test::FreshFolder("command_line_broken") / "out";
    for (const char* command : {"discretize", "run"}) {
      const Ended ended = Type(
          {command, "--mesh", file.string(), "--height", "20", "--out", out.string()});
      EXPECT_EQ(ended.exit_code, 2) << command << " " << file << "\n" << ended.output;
      EXPECT_TRUE(ended.in_time);
      EXPECT_THAT(ended.output, HasSubstr(file.filename().string()));
      EXPECT_GT(ended.output.size(), file.string().size() + 30) << "and says what to do";
      EXPECT_FALSE(fs::exists(out));
    }
  }
  EXPECT_EQ(tried, 7u);
}

TEST(CommandLine, ASoundModelWithoutNormalsIsTaken) {
  const fs::path folder = test::FreshFolder("command_line_no_normals");
  const fs::path model = folder / "no_normals.STL", out = folder / "cloud.ply";
  std::ofstream(model, std::ios::binary)
      << mesh::BinaryStl(discretize::Trefoil(0.4, 160, 12));
  const Ended ended = Type({"discretize", "--mesh", model.string(), "--height", "20",
                            "--spacing", "0.3", "--out", out.string()});
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_TRUE(fs::exists(out));
}

TEST(CommandLine, AFolderThatCannotBeWrittenIsNamed) {
  const std::string model = INTAGLIO_SOURCE_DIR "/deploy/jobs/sample.obj";
  for (const char* command : {"discretize", "run"}) {
    const Ended ended = Type({command, "--mesh", model, "--height", "20", "--spacing",
                              "0.5", "--out", "/proc/no/such/place.ply"});
    EXPECT_EQ(ended.exit_code, 2) << command;
    EXPECT_THAT(ended.output, HasSubstr("/proc/no/such/place.ply")) << command;
  }
  const Ended up = Type({"up", "--folder", "/proc/no/such/place"});
  EXPECT_EQ(up.exit_code, 2);
  EXPECT_THAT(up.output, HasSubstr("/proc/no/such/place"));
}

// The table of docs/cli.md against the enumeration, so that neither changes alone.
Ended TypeInShell(const std::string& line) {
  const fs::path folder = test::FreshFolder();
  setenv("INTAGLIO_MATERIALS_DB", (folder / "materials.db").c_str(), 1);
  Running run("/bin/sh", {"-c", "cd " + folder.string() + " && " + line},
              folder / "output.txt");
  return run.WaitForEnd(30s);
}

// A table on a disk that is full is not a table.
TEST(CommandLine, ResultsThatCannotBeWrittenAreNoSuccess) {
  const std::string intaglio = Program("intaglio").string();
  for (const char* command :
       {" materials list", " materials list --json", " help discretize", " --help"}) {
    const Ended full = TypeInShell(intaglio + command + " > /dev/full");
    EXPECT_EQ(full.exit_code, client::kExitWrongInput) << command;
    EXPECT_THAT(full.output, HasSubstr("standard output cannot be written")) << command;
  }
  EXPECT_EQ(TypeInShell(intaglio + " materials list > list.txt").exit_code, 0);
  const Ended closed = TypeInShell(intaglio + " materials list >&-");
  EXPECT_EQ(closed.exit_code, client::kExitWrongInput);
  EXPECT_THAT(closed.output, HasSubstr("standard output cannot be written"));
}

TEST(CommandLine, ExitCodesAreAsDocumented) {
  const std::string document = TextIn(INTAGLIO_SOURCE_DIR "/docs/cli.md");
  for (const auto& [code, word] : std::vector<std::pair<int, std::string>>{
           {client::kExitGood, "good"},
           {client::kExitInternal, "internal"},
           {client::kExitWrongInput, "wrong input"},
           {client::kExitNotGood, "verdict is not good"},
           {client::kExitMachine, "machine"},
           {client::kExitCancelled, "cancelled"},
           {client::kExitLeft, "no longer followed"}}) {
    const std::regex row("\\| " + std::to_string(code) + " \\| [^|]*" + word);
    EXPECT_TRUE(std::regex_search(document, row)) << code << " " << word;
  }
}

TEST(CommandLine, AnUnknownGlassIsAnsweredWithNamesThatAreNear) {
  const Ended shown = Type({"materials", "show", "N-BK77"});
  EXPECT_EQ(shown.exit_code, 2);
  EXPECT_THAT(shown.output, HasSubstr("N-BK7"));
}

}  // namespace
}  // namespace intaglio
