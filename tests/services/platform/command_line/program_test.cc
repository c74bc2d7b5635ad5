#include "services/platform/command_line/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>

namespace intaglio::command_line {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// "understood", or the output.
std::string Output(Program& program, std::vector<std::string> words) {
  const Status parsed = program.Parse(std::move(words));
  return parsed ? "understood" : parsed.error().message;
}

struct Exit {
  std::optional<int> code;
  std::string out, err;
};

Exit ParseAsMain(Program& program, std::vector<std::string> words) {
  words.insert(words.begin(), "/usr/bin/somewhere");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Exit exit;
  exit.code = program.Parse(static_cast<int>(argv.size()), argv.data());
  exit.out = testing::internal::GetCapturedStdout();
  exit.err = testing::internal::GetCapturedStderr();
  return exit;
}

TEST(Option, TakesEachKindOfValue) {
  int whole = 0;
  std::uint32_t number = 0;
  std::uint64_t large = 0;
  double length_mm = 0;
  std::string name;
  std::filesystem::path file;
  std::optional<double> maybe_mm, unsaid_mm;
  std::vector<double> corner_mm;
  std::vector<std::string> words;
  bool flag = false, turned_off = true;
  int parent = 0;
  Program program("p", "");
  const Command root = program.root();
  root.AddOption("WORDS", words, "");
  root.AddOption("--whole", whole, "");
  root.AddOption("--number", number, "");
  root.AddOption("--large", large, "");
  root.AddOption("--length", length_mm, "");
  root.AddOption("--name,--called", name, "");
  root.AddOption("--file", file, "");
  root.AddOption("--maybe", maybe_mm, "");
  root.AddOption("--unsaid", unsaid_mm, "");
  root.AddOption("--corner", corner_mm, "").SplitAt(',').TakeValues(3);
  root.AddFlag("--flag", flag, "");
  root.AddFlag("--on,!--off", turned_off, "");
  root.AddFlag("--parent{-1}", parent, "");
  ASSERT_EQ(Output(program, {"a",
                             "b c",
                             "--whole",
                             "-7",
                             "--number",
                             "4294967295",
                             "--large=18446744073709551615",
                             "--length",
                             "1.5",
                             "--called",
                             "x",
                             "--file",
                             "/a b",
                             "--maybe",
                             "2",
                             "--corner",
                             "1,2,3",
                             "--flag",
                             "--off",
                             "--parent=12"}),
            "understood");
  EXPECT_EQ(whole, -7);
  EXPECT_EQ(number, 4294967295u);
  EXPECT_EQ(large, 18446744073709551615u);
  EXPECT_EQ(length_mm, 1.5);
  EXPECT_EQ(name, "x");
  EXPECT_EQ(file, "/a b");
  EXPECT_EQ(maybe_mm, 2.0);
  EXPECT_EQ(unsaid_mm, std::nullopt);
  EXPECT_THAT(corner_mm, ElementsAre(1, 2, 3));
  EXPECT_THAT(words, ElementsAre("a", "b c"));
  EXPECT_TRUE(flag);
  EXPECT_FALSE(turned_off);
  EXPECT_EQ(parent, 12);
  ASSERT_EQ(Output(program, {"--parent"}), "understood");
  EXPECT_EQ(parent, -1) << "without a value";
}

TEST(Option, ThatIsNotAsItHasToBeIsNamed) {
  double rate = 1, height = 0, size = 0, width = 1;
  int count = 1;
  std::string format, out;
  std::vector<double> corner;
  Program program("p", "");
  const Command root = program.root();
  root.AddOption("--out", out, "").Require();
  root.AddOption("--rate", rate, "").Within(0.5, 2.0);
  root.AddOption("--count", count, "").Within(1, 4);
  root.AddOption("--width", width, "").Positive();
  root.AddOption("--format", format, "").OneOf({"csv", "ply"});
  const Option of_height = root.AddOption("--height", height, "");
  root.AddOption("--size", size, "").Exclude(of_height);
  root.AddOption("--corner", corner, "").TakeValues(3).Need(root.OptionOf("--format"));
  const auto output = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--out", "x"});
    return Output(program, words);
  };
  EXPECT_EQ(output({"--rate", "2", "--count", "4", "--format", "ply"}), "understood");
  EXPECT_THAT(Output(program, {}), HasSubstr("--out is required"));
  EXPECT_THAT(output({"--rate", "2.1"}),
              HasSubstr("--rate: '2.1' is no number from 0.5 to 2"));
  EXPECT_THAT(output({"--rate", "fast"}), HasSubstr("--rate: 'fast' is no number"));
  EXPECT_THAT(output({"--count", "0"}),
              HasSubstr("--count: '0' is no whole number from 1 to 4"));
  EXPECT_THAT(output({"--count", "1.5"}), HasSubstr("--count: '1.5' is no whole"));
  EXPECT_THAT(output({"--width", "0"}), HasSubstr("--width: '0' is no number above 0"));
  EXPECT_THAT(output({"--height", "tall"}),
              HasSubstr("--height: 'tall' cannot be read as a number"));
  EXPECT_THAT(output({"--format", "csv", "--corner", "a", "b", "c"}),
              HasSubstr("--corner: 'a,b,c' cannot be read as numbers"));
  EXPECT_THAT(output({"--format", "doc"}), HasSubstr("--format"));
  EXPECT_THAT(output({"--height", "1", "--size", "2"}), HasSubstr("--height"));
  EXPECT_THAT(output({"--format", "csv", "--corner", "1", "2"}), HasSubstr("--corner"));
  EXPECT_THAT(output({"--corner", "1", "2", "3"}), HasSubstr("--format"));
}

TEST(Option, IsTakenFromTheEnvironmentWhenItIsNotGiven) {
  std::string keys;
  Program program("p", "");
  program.root().AddOption("--keys", keys, "").FromEnvironment("INTAGLIO_TEST_KEYS");
  setenv("INTAGLIO_TEST_KEYS", "from there", 1);
  EXPECT_EQ(Output(program, {}), "understood");
  EXPECT_EQ(keys, "from there");
  EXPECT_EQ(Output(program, {"--keys", "given"}), "understood");
  EXPECT_EQ(keys, "given");
  unsetenv("INTAGLIO_TEST_KEYS");
}

// "--size: 'abc' ..." blames an option that nobody has written.
TEST(Option, WhoseValueComesFromTheEnvironmentIsCalledByItsVariable) {
  int size = 0;
  Program program("p", "");
  const auto list = program.root().AddCommand("list", "");
  list.AddOption("--size", size, "").Within(0, 9).FromEnvironment("INTAGLIO_TEST_SIZE");
  list.SetAction([] { return 0; });
  setenv("INTAGLIO_TEST_SIZE", "abc", 1);
  EXPECT_THAT(Output(program, {"list"}),
              HasSubstr("INTAGLIO_TEST_SIZE: 'abc' is no whole number from 0 to 9"));
  EXPECT_THAT(Output(program, {"list", "--size", "10"}), HasSubstr("--size: '10'"));
  EXPECT_THAT(Output(program, {"list", "--size=10"}), HasSubstr("--size: '10'"));
  unsetenv("INTAGLIO_TEST_SIZE");
}

// Commands that share their values: the variable of the other command replaced what was
// given, so that `list --domain 33` listed the shop of INTAGLIO_DOMAIN.
TEST(Option, ThatIsGivenPrecedesTheVariableOfAnotherCommand) {
  std::string shop;
  Program program("p", "");
  for (const char* const name : {"list", "arm"}) {
    const auto command = program.root().AddCommand(name, "");
    command.AddOption("--shop", shop, "").FromEnvironment("INTAGLIO_TEST_SHOP");
    command.SetAction([] { return 0; });
  }
  setenv("INTAGLIO_TEST_SHOP", "there", 1);
  for (const char* const name : {"list", "arm"}) {
    EXPECT_EQ(Output(program, {name, "--shop", "here"}), "understood");
    EXPECT_EQ(shop, "here") << name;
    EXPECT_EQ(Output(program, {name}), "understood");
    EXPECT_EQ(shop, "there") << name;
  }
  unsetenv("INTAGLIO_TEST_SHOP");
}

// teach --domain 33 jog moved the machine of another domain.
TEST(Option, ThatIsGivenBeforeACommandIsOfThatCommand) {
  std::string screens, shop;
  double size = 0;
  Program program("p", "");
  const auto teach = program.root().AddCommand("teach", "");
  teach.AddOption("--shop", screens, "").FromEnvironment("INTAGLIO_TEST_SHOP");
  teach.AddOption("--size", size, "");
  const auto status = teach.AddCommand("status", "");
  status.AddOption("--shop", shop, "").FromEnvironment("INTAGLIO_TEST_SHOP");
  status.SetAction([] { return 0; });
  for (const bool has_variable : {false, true}) {
    if (has_variable) setenv("INTAGLIO_TEST_SHOP", "there", 1);
    EXPECT_EQ(Output(program, {"teach", "--shop", "here", "status"}), "understood");
    EXPECT_EQ(shop, "here");
    EXPECT_EQ(Output(program, {"teach", "status", "--shop", "near"}), "understood");
    EXPECT_EQ(shop, "near");
  }
  EXPECT_EQ(Output(program, {"teach", "status"}), "understood");
  EXPECT_EQ(shop, "there");
  unsetenv("INTAGLIO_TEST_SHOP");
  EXPECT_THAT(Output(program, {"teach", "--size", "3", "status"}),
              HasSubstr("--size: is an option of p teach, and not of p teach status"));
}

TEST(Command, ThatWasGivenActs) {
  Program program("intaglio", "");
  const Command recording = program.root().AddCommand("recording", "");
  recording.RequireCommand();
  std::string database;
  recording.AddOption("--db", database, "");
  const Command info = recording.AddCommand("info", "");
  info.TakeOptionsOfParent();
  info.SetAction([] { return 7; });
  recording.AddCommand("cut", "").SetAction([] { return 8; });
  EXPECT_EQ(Output(program, {"recording", "info", "--db", "x"}), "understood");
  EXPECT_EQ(program.Run(), 7);
  EXPECT_EQ(database, "x");
  EXPECT_THAT(Output(program, {"recording"}),
              HasSubstr("intaglio recording needs a command: info, cut; see"));
  EXPECT_NE(Output(program, {"recording", "cut", "--db", "x"}), "understood");
}

TEST(Program, EndsWithZeroAfterItsHelpAndWithTwoAfterArgumentsItDoesNotKnow) {
  double rate = 1.5;
  Program program("intaglio", "A mesh goes in.");
  program.SetVersion("1.2.3");
  program.root().SetFooter("Where to begin.");
  program.root().AddOption("--rate", rate, "how fast").ShowDefault().Describe("the rate");
  const Exit help = ParseAsMain(program, {"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* part :
       {"A mesh goes in.", "intaglio", "--rate", "1.5", "the rate", "Where to begin."})
    EXPECT_THAT(help.out, HasSubstr(part));
  const Exit version = ParseAsMain(program, {"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out, "1.2.3\n");
  const Exit wrong = ParseAsMain(program, {"--rate", "fast"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--rate"));
  const Exit unknown = ParseAsMain(program, {"--rte", "2"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean --rate?"));
  EXPECT_EQ(ParseAsMain(program, {"--rate", "2"}).code, std::nullopt);
  EXPECT_EQ(rate, 2);
}

TEST(Program, WithoutACommandShowsItsHelp) {
  Program program("intaglio", "A mesh goes in.");
  program.root().AddCommand("list", "").SetAction([] { return 7; });
  ASSERT_EQ(Output(program, {}), "understood");
  testing::internal::CaptureStdout();
  EXPECT_EQ(program.Run(), 0);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("A mesh goes in."));
}

TEST(Program, HelpOfACommandIsThatOfItsOption) {
  double rate = 1;
  const auto output = [&](std::vector<std::string> words) {
    Program program("intaglio", "A mesh goes in.");
    const Command recording =
        program.root().AddCommand("recording", "inspect recordings");
    recording.AddCommand("cut", "a span").AddOption("--from", rate, "seconds");
    program.AddHelpCommand();
    Exit exit = ParseAsMain(program, std::move(words));
    if (exit.code) return exit;
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    exit.code = program.Run();
    exit.out = testing::internal::GetCapturedStdout();
    exit.err = testing::internal::GetCapturedStderr();
    return exit;
  };
  const Exit cut = output({"help", "recording", "cut"});
  EXPECT_EQ(cut.code, 0);
  EXPECT_EQ(cut.out, output({"recording", "cut", "--help"}).out);
  EXPECT_THAT(cut.out, HasSubstr("Usage: intaglio recording cut"));
  EXPECT_EQ(output({"help"}).out, output({"--help"}).out);
  const Exit mistyped = output({"help", "recording", "cat"});
  EXPECT_EQ(mistyped.code, 2);
  EXPECT_EQ(mistyped.err,
            "intaglio recording has no command 'cat', did you mean cut?; see intaglio "
            "recording --help\n");
}

TEST(Program, DescribesItsCommandsAndOptions) {
  std::string database, format;
  std::vector<std::string> meshes;
  bool flag = false;
  int count = 3;
  Program program("intaglio", "A mesh goes in.");
  const Command materials = program.root().AddCommand("materials", "the glasses");
  materials.AddOption("--db", database, "material base").FromEnvironment("GLASSES");
  const Command list = materials.AddCommand("list", "list the glasses");
  list.TakeOptionsOfParent();
  list.AddOption("GLASS", format, "its name").Require();
  list.AddOption("--mesh,--model", meshes, "model").Group("Model");
  list.AddOption("--format", format, "of the table").OneOf({"csv", "json"});
  list.AddOption("--count", count, "how many").ShowDefault();
  list.AddFlag("--all", flag, "all of them");
  list.SetFooter("Example: intaglio materials list");
  const CommandDescription root = program.Describe();
  EXPECT_EQ(root.purpose, "A mesh goes in.");
  ASSERT_EQ(root.commands.size(), 1u);
  ASSERT_EQ(root.commands[0].commands.size(), 1u);
  const CommandDescription& described = root.commands[0].commands[0];
  EXPECT_THAT(described.words, ElementsAre("materials", "list"));
  EXPECT_EQ(described.purpose, "list the glasses");
  EXPECT_EQ(described.footer, "Example: intaglio materials list");
  std::map<std::string, OptionDescription> options;
  for (const OptionDescription& option : described.options) {
    options[option.names.back()] = option;
  }
  EXPECT_TRUE(options.at("GLASS").positional);
  EXPECT_TRUE(options.at("GLASS").required);
  EXPECT_THAT(options.at("--model").names, ElementsAre("--mesh", "--model"));
  EXPECT_TRUE(options.at("--model").repeatable);
  EXPECT_EQ(options.at("--model").group, "Model");
  EXPECT_THAT(options.at("--format").choices, ElementsAre("csv", "json"));
  EXPECT_EQ(options.at("--count").default_value, "3");
  EXPECT_EQ(options.at("--count").value, "INT");
  EXPECT_EQ(options.at("--all").value, "") << "a flag";
  EXPECT_FALSE(options.at("--all").repeatable);
  EXPECT_EQ(options.at("--db").variable, "GLASSES") << "of the command above";
  EXPECT_EQ(options.count("--help"), 1u);
}

class UnknownArguments : public testing::Test {
 protected:
  UnknownArguments() : program_("intaglio", "an app") {
    program_.root().AddCommand("run", "").AddOption("--height", height_, "");
    program_.root().AddCommand("recording", "").AddCommand("repair", "");
  }
  std::string Output(std::vector<std::string> words) {
    return command_line::Output(program_, std::move(words));
  }
  double height_ = 0;
  Program program_;
};

TEST_F(UnknownArguments, ACommandIsNamedWithTheNearestOne) {
  EXPECT_EQ(Output({"rum", "--height", "3"}),
            "intaglio has no command 'rum', did you mean run?; see intaglio --help");
  EXPECT_EQ(Output({"engrave"}),
            "intaglio has no command 'engrave'; see intaglio --help");
}

TEST_F(UnknownArguments, AnOptionIsThatOfTheInnermostCommand) {
  EXPECT_EQ(Output({"run", "--hieght=3"}),
            "intaglio run has no option '--hieght', did you mean --height?; see intaglio "
            "run --help");
  EXPECT_EQ(Output({"recording", "repiar", "x"}),
            "intaglio recording has no command 'repiar', did you mean repair?; see "
            "intaglio recording --help");
}

TEST_F(UnknownArguments, AnOptionOfOtherCommandsIsNamedWithThem) {
  EXPECT_EQ(Output({"recording", "repair", "--height", "3"}),
            "intaglio recording repair has no option '--height' (an option of run); see "
            "intaglio recording repair --help");
}

TEST_F(UnknownArguments, AMistypedOptionIsReportedBeforeThatItIsMissing) {
  std::string out;
  program_.root().AddCommand("render", "").AddOption("--out", out, "").Require();
  EXPECT_THAT(Output({"render", "--oat", "x"}), HasSubstr("did you mean --out?"));
  EXPECT_THAT(Output({"render"}), HasSubstr("--out is required"));
}

TEST_F(UnknownArguments, AValueThatIsNoChoiceIsNamedWithTheNearestOne) {
  std::string format;
  program_.root()
      .AddCommand("export", "")
      .AddOption("--format", format, "")
      .OneOf({"jsonl", "csv"});
  EXPECT_THAT(Output({"export", "--format", "cvs"}),
              HasSubstr("'cvs' is none of jsonl, csv, did you mean csv?"));
  EXPECT_EQ(Output({"export", "--format", "csv"}), "understood");
}

TEST_F(UnknownArguments, AnArgumentTooManyIsNotTakenForACommand) {
  EXPECT_EQ(Output({"run", "--height", "3", "more"}),
            "intaglio run does not accept 'more'; see intaglio run --help");
  EXPECT_EQ(Output({"run", "--height", "3"}), "understood");
}

}  // namespace
}  // namespace intaglio::command_line
