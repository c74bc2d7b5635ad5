// The table of commands: every command has help and a place in the documentation, and
// only the options that change what it does.

#include "services/cli/intaglio_program.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "services/cli/flags/job_flags.h"
#include "services/platform/command_line/completion.h"
#include "services/platform/command_line/man_page.h"
#include "tests/services/cli/all_commands.h"

namespace intaglio::cli {
namespace {

using command_line::CommandDescription;
using command_line::OptionDescription;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Document(const std::string& name) {
  std::ifstream in(INTAGLIO_SOURCE_DIR "/docs/" + name);
  EXPECT_TRUE(in) << name;
  return {std::istreambuf_iterator<char>(in), {}};
}

std::set<std::string> OptionsIn(const std::string& text) {
  std::set<std::string> options;
  const std::regex option("(^|[\\s`\"(,])(--[a-z][a-z-]*)");
  for (std::sregex_iterator at(text.begin(), text.end(), option), end; at != end; ++at) {
    options.insert((*at)[2]);
  }
  return options;
}

std::string NameOf(const CommandDescription& command) {
  return fmt::format("{}", fmt::join(command.words, " "));
}

/// Names of the options of a command; of positional arguments without dashes.
std::set<std::string> OptionsOf(const std::string& name) {
  std::set<std::string> options;
  for (const CommandDescription& command : AllCommands()) {
    if (NameOf(command) != name) continue;
    for (const OptionDescription& option : command.options) {
      options.insert(option.names.begin(), option.names.end());
    }
  }
  EXPECT_FALSE(options.empty()) << name;
  return options;
}

Status ParsedBy(const std::vector<std::string>& words) {
  return IntaglioProgram()->Parse(words);
}

TEST(IntaglioProgram, EveryCommandHasHelpAndAPlaceInTheDocumentation) {
  const std::string document = Document("cli.md") + Document("jobs.md") +
                               Document("materials.md") + Document("machines/drives.md") +
                               Document("machines/galvo.md");
  const std::set<std::string> documented = OptionsIn(document);
  std::set<std::string> known = {"--version"};
  for (const CommandDescription& command : AllCommands()) {
    const std::string name = NameOf(command);
    EXPECT_NE(command.purpose, "") << name;
    EXPECT_THAT(document, HasSubstr(name));
    // docs/materials.md has a table of what they have in common.
    const bool of_materials = name.starts_with("materials ");
    if (!of_materials) {
      EXPECT_THAT(command.footer, HasSubstr("Example: intaglio " + name));
    }
    for (const OptionDescription& option : command.options) {
      EXPECT_NE(option.meaning, "") << name << " " << option.names.front();
      for (const std::string& word : option.names) {
        if (!word.starts_with("--")) continue;
        known.insert(word);
        EXPECT_TRUE(of_materials || word == "--help" || documented.contains(word))
            << name << " " << word;
      }
    }
  }
  known.insert("--no-record");  // of --record
  // And nothing is documented that is not there.
  for (const std::string& option : OptionsIn(Document("cli.md"))) {
    EXPECT_TRUE(known.contains(option)) << option;
  }
}

TEST(IntaglioProgram, ACommandHasOnlyTheOptionsThatItUses) {
  const auto all = OptionsOf("run");
  EXPECT_THAT(all, AllOf(Contains("--mesh"), Contains("--method"), Contains("--layer"),
                         Contains("--order"), Contains("--rate"), Contains("--glass"),
                         Contains("--name")));
  JobFlags flags;
  command_line::Program of_a_job("of a job", "");
  AddJobFlags(of_a_job.root(), flags);
  for (const OptionDescription& option : of_a_job.Describe().options) {
    EXPECT_THAT(all, Contains(option.names.front()));
    EXPECT_THAT(OptionsOf("submit"), Contains(option.names.front()));
  }
  // Makes points: neither orders nor moves.
  EXPECT_THAT(OptionsOf("discretize"),
              AllOf(Contains("--mesh"), Contains("--method"), Contains("--shells"),
                    Contains("--clip"), Not(Contains("--order")), Not(Contains("--rate")),
                    Not(Contains("--acceleration")), Not(Contains("--name"))));
  // Have the points.
  for (const char* name : {"sort", "plan"}) {
    EXPECT_THAT(
        OptionsOf(name),
        AllOf(Contains("--block"), Contains("--rate"), Contains("--profile"),
              Contains("--machine"), Contains("--glass"), Not(Contains("--rotate")),
              Not(Contains("--mesh")), Not(Contains("--method")),
              Not(Contains("--layer")), Not(Contains("--clip")),
              Not(Contains("--margin")), Not(Contains("--name"))))
        << name;
  }
  EXPECT_THAT(OptionsOf("sort"), AllOf(Contains("--order"), Contains("--spacing")));
  EXPECT_THAT(OptionsOf("plan"),
              AllOf(Not(Contains("--order")), Not(Contains("--spacing"))));
  EXPECT_THAT(OptionsOf("measure"),
              AllOf(Contains("--mesh"), Contains("--rotate"), Contains("--focal"),
                    Not(Contains("--glass")), Not(Contains("--order"))));
}

TEST(IntaglioProgram, AnOptionThatDoesNothingIsRefusedWithTheCommandsThatHaveIt) {
  const auto plan = ParsedBy({"plan", "--path", "a.ply", "--rotate", "1", "2", "3"});
  ASSERT_FALSE(plan);
  EXPECT_THAT(plan.error().message, HasSubstr("intaglio plan has no option '--rotate' "
                                              "(an option of run, submit"));
  const auto method = ParsedBy({"run", "--method", "sectoins", "--mesh", "a.stl"});
  ASSERT_FALSE(method);
  EXPECT_THAT(method.error().message, HasSubstr("did you mean sections?"));
  const auto command = ParsedBy({"sumbit", "job.textproto"});
  ASSERT_FALSE(command);
  EXPECT_THAT(command.error().message, HasSubstr("did you mean submit?"));
}

/// Whether the parser has this option of the command; what else is wrong with a line of
/// nothing but this option does not matter.
bool IsOptionOf(command_line::Program& program, const std::string& command,
                const std::string& option) {
  std::vector<std::string> words;
  std::istringstream in(command);
  for (std::string word; in >> word;) words.push_back(word);
  words.push_back(option);
  const Status parsed = program.Parse(words);
  return parsed || parsed.error().message.find("has no option") == std::string::npos;
}

/// What the script for bash offers behind each command, read from its text.
std::map<std::string, std::set<std::string>> OfferedByBash() {
  const std::string script =
      command_line::BashCompletion("intaglio", IntaglioProgram()->Describe());
  std::map<std::string, std::set<std::string>> offered;
  const std::regex line("'([^']*)'\\) commands='[^']*' options='([^']*)' ;;");
  for (std::sregex_iterator at(script.begin(), script.end(), line), end; at != end;
       ++at) {
    std::istringstream in((*at)[2]);
    for (std::string option; in >> option;) offered[(*at)[1]].insert(option);
  }
  return offered;
}

std::string ManPagesWithoutEscapes() {
  std::string text;
  for (const command_line::ManPage& page :
       command_line::ManPagesOf("intaglio", IntaglioProgram()->Describe())) {
    text += page.text;
  }
  std::erase(text, '\\');
  return text;
}

TEST(IntaglioProgram, CompletionAndManualPagesHaveTheOptionsThatTheParserTakes) {
  const auto program = IntaglioProgram();
  const auto offered = OfferedByBash();
  const std::string pages = ManPagesWithoutEscapes();
  for (const CommandDescription& command : AllCommands()) {
    const std::string name = NameOf(command);
    ASSERT_TRUE(offered.contains(name)) << name;
    for (const std::string& option : offered.at(name)) {
      EXPECT_TRUE(IsOptionOf(*program, name, option)) << name << " " << option;
      EXPECT_THAT(pages, HasSubstr("fB" + option + "fR")) << name;
    }
    EXPECT_FALSE(IsOptionOf(*program, name, "--not-there")) << name;
  }
  // What people type and the parser takes is offered, known here without the tables.
  EXPECT_THAT(offered.at("run"), AllOf(Contains("--mesh"), Contains("--lockstep")));
  EXPECT_THAT(offered.at("plan"), Not(Contains("--rotate")));
  EXPECT_THAT(offered.at("list"), AllOf(Contains("--json"), Contains("--tag")));
}

}  // namespace
}  // namespace intaglio::cli
