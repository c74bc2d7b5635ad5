#include "services/platform/command_line/completion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/services/platform/command_line/sample_commands.h"
#include "tests/test_folder.h"

namespace intaglio::command_line {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string OutputOf(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return "cannot be started";
  std::string output;
  std::array<char, 4096> buffer;
  while (const std::size_t size = fread(buffer.data(), 1, buffer.size(), pipe))
    output.append(buffer.data(), size);
  const int status = pclose(pipe);
  return status == 0 ? output : output + "failed";
}

class Completion : public ::testing::Test {
 protected:
  std::string Write(const std::string& text) const {
    const fs::path file = folder_ / "completion";
    std::ofstream(file) << text;
    return file.string();
  }
  /// What bash offers for the last of the words, on one line.
  std::string Bash(const std::string& words) const {
    const std::string file = Write(BashCompletion("shop", SampleCommands()));
    return OutputOf("bash -u -c 'source \"" + file + "\"; COMP_WORDS=(" + words +
                    "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _shop; "
                    "echo \"${COMPREPLY[*]:-}\"'");
  }
  fs::path folder_ = test::FreshFolder();
};

TEST_F(Completion, BashOffersCommandsOptionsAndChoices) {
  EXPECT_EQ(Bash("shop \"\""), "run recording\n");
  EXPECT_EQ(Bash("shop re"), "recording\n");
  EXPECT_EQ(Bash("shop recording \"\""), "info cut\n");
  EXPECT_EQ(Bash("shop recording cut --o"), "--order\n");
  EXPECT_EQ(Bash("shop run --"), "--help --order --domain --dds-domain\n");
  EXPECT_EQ(Bash("shop run --order \"\""), "anneal layers\n");
  EXPECT_EQ(Bash("shop run --order la"), "layers\n");
  EXPECT_EQ(Bash("shop run --order = an"), "anneal\n");
  EXPECT_EQ(Bash("shop run --order ="), "anneal layers\n");
  // A file's name: the shell's own completion takes it.
  EXPECT_EQ(Bash("shop run kno"), "\n");
}

TEST_F(Completion, TheShellsAcceptTheirScripts) {
  const std::string bash = Write(BashCompletion("shop", SampleCommands()));
  EXPECT_EQ(OutputOf("bash -n '" + bash + "' 2>&1"), "");
  const std::string zsh = Write(ZshCompletion("shop", SampleCommands()));
  if (fs::exists("/usr/bin/zsh")) {
    EXPECT_EQ(OutputOf("zsh -n '" + zsh + "' 2>&1"), "");
  }
  const std::string fish = Write(FishCompletion("shop", SampleCommands()));
  if (!fs::exists("/usr/bin/fish")) return;
  EXPECT_EQ(OutputOf("fish -n '" + fish + "' 2>&1"), "");
  const auto offered = [&](const std::string& line) {
    return OutputOf("HOME='" + folder_.string() + "' fish --no-config -c 'source \"" +
                    fish + "\"; complete -C\"" + line + "\"' 2>&1");
  };
  EXPECT_EQ(offered("shop r"), "recording\tfiles of recordings\nrun\tengrave one job\n");
  EXPECT_EQ(offered("shop run --order la"), "layers\torder of the points\n");
  EXPECT_EQ(offered("shop recording i"), "info\twhat is in it\n");
}

TEST_F(Completion, ZshDescribesCommandsAndOptions) {
  const std::string text = ZshCompletion("shop", SampleCommands());
  EXPECT_THAT(text, HasSubstr("#compdef shop\n"));
  EXPECT_THAT(text, HasSubstr("commands=('info:what is in it' 'cut:a span of time')"));
  EXPECT_THAT(text, HasSubstr("'--dds-domain:where the shop'\\''s programs meet'"));
  EXPECT_THAT(text, HasSubstr("'run --order') compadd -- anneal layers; return ;;"));
}

}  // namespace
}  // namespace intaglio::command_line
