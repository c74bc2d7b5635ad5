// --json: every command has it, and what is refused is one object with a code.

#include "services/cli/terminal/command_outcome.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <regex>
#include <stdexcept>

#include "proto/console.pb.h"
#include "proto/shop.pb.h"
#include "services/cli/terminal/complain.h"
#include "services/client/job_view.h"
#include "services/client/refusal_code.h"
#include "tests/services/cli/all_commands.h"
#include "tests/services/cli/typed_command.h"

namespace intaglio::cli {
namespace {

using command_line::CommandDescription;
using command_line::OptionDescription;
using ::testing::HasSubstr;

bool HasJson(const CommandDescription& command) {
  for (const OptionDescription& option : command.options) {
    if (option.names.front() == "--json") return true;
  }
  return false;
}

/// The whole text is one CommandAnswer.
CommandAnswer AnswerIn(const std::string& text) {
  CommandAnswer answer;
  const auto read = google::protobuf::util::JsonStringToMessage(text, &answer);
  EXPECT_TRUE(read.ok()) << text << "\n" << read.ToString();
  return answer;
}

class JsonOfCommands : public TypedCommand {
 protected:
  /// `act` as the action of a command without a message of its own.
  int Act(const std::function<int()>& act) {
    return Run([&](command_line::Command command) { command.SetAction(act); });
  }
  int Run(const std::function<void(command_line::Command)>& describe,
          const char* form = "--json") {
    command_line::Program program("intaglio", "");
    describe(program.root().AddCommand("try", "for a test"));
    AnswerInJson(program);
    EXPECT_TRUE(program.Parse({"try", form}));
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = program.Run();
    output_ = ::testing::internal::GetCapturedStdout();
    errors_ = ::testing::internal::GetCapturedStderr();
    return code;
  }
};

TEST_F(JsonOfCommands, EveryCommandHasItOrAReasonNotTo) {
  std::size_t acting = 0;
  for (const CommandDescription& command : AllCommands()) {
    const std::string name = fmt::format("{}", fmt::join(command.words, " "));
    const bool is_left_out = ReasonForNoJson(name) != nullptr || name == "help";
    if (command.acts) ++acting;
    EXPECT_EQ(HasJson(command), command.acts && !is_left_out) << name;
    EXPECT_TRUE(command.acts || !is_left_out) << name;
  }
  EXPECT_GT(acting, 70u);
}

// The same line for each command of the program, as a script would get it wrong.
TEST_F(JsonOfCommands, ALineThatIsNotUnderstoodIsOneObjectWithACode) {
  for (const CommandDescription& command : AllCommands()) {
    if (!command.acts || command.words.front() == "help") continue;
    std::vector<std::string> words = {"intaglio"};
    words.insert(words.end(), command.words.begin(), command.words.end());
    words.insert(words.end(), {"--json", "--not-there"});
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    const auto program = IntaglioProgram();
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto code = program->Parse(static_cast<int>(argv.size()), argv.data());
    const CommandAnswer answer = AnswerIn(::testing::internal::GetCapturedStdout());
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(code, client::kExitWrongInput) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_FALSE(answer.taken());
    EXPECT_EQ(answer.code(), "invalid_value");
    EXPECT_THAT(answer.message(), HasSubstr(HasJson(command) ? "--not-there" : "--json"));
  }
}

TEST_F(JsonOfCommands, WhatACommandRefusesIsOneObjectWithACode) {
  const std::string none = folder_ / "none";
  const std::string bad = folder_ / "bad.ply";
  std::ofstream(bad) << "no cloud";
  struct Refused {
    std::vector<std::string> words;
    std::string code;
  };
  const std::vector<Refused> table = {
      {{"arm"}, "missing"},
      {{"speed", "1", "300"}, "invalid_value"},
      {{"submit", "--series", none, "--arm"}, "invalid_value"},
      {{"again", "1", "--folder", none}, "not_found"},
      {{"teach", "zero", "--axes", "q"}, "invalid_value"},
      {{"teach", "pulse"}, "missing"},
      {{"teach", "history", "--machine", none}, "unsupported"},
      {{"history", "--folder", none}, "not_found"},
      {{"logs", "--folder", none}, "not_found"},
      {{"restore", none, "--list"}, "not_found"},
      {{"preview", none}, "not_found"},
      {{"sort", "--cloud", bad, "--out", none}, "unreadable"},
      {{"post", none, "--out", none}, "not_found"},
      {{"sheet", "use", none + ".dxf"}, "not_found"},
      {{"machine", "check", none}, "not_found"},
      {{"materials", "--db", folder_ / "m.db", "remove", "ice"}, "not_found"},
      {{"materials", "--db", folder_ / "m.db", "show", "ice"}, "not_found"},
      {{"fonts", "no such family"}, "not_found"},
      {{"recording", "info", none}, "not_found"},
      {{"replay", none}, "not_found"},
      {{"security", "check", none}, "not_found"},
      {{"console", "user", "remove", "anna", "--users", none}, "not_found"}};
  for (const Refused& refused : table) {
    std::vector<std::string> words = refused.words;
    words.push_back("--json");
    const std::string line = fmt::format("{}", fmt::join(words, " "));
    const auto program = IntaglioProgram();
    std::vector<std::string> all = {"intaglio"};
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char*> argv;
    for (std::string& word : all) argv.push_back(word.data());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto parsed = program->Parse(static_cast<int>(argv.size()), argv.data());
    const int code = parsed ? *parsed : program->Run();
    const CommandAnswer answer = AnswerIn(::testing::internal::GetCapturedStdout());
    ::testing::internal::GetCapturedStderr();
    EXPECT_NE(code, client::kExitGood) << line;
    EXPECT_FALSE(answer.taken()) << line;
    EXPECT_EQ(answer.code(), refused.code) << line << ": " << answer.message();
    EXPECT_NE(answer.message(), "") << line;
  }
}

TEST_F(JsonOfCommands, WhatAPersonReadsIsTheMessage) {
  EXPECT_EQ(Act([] {
              std::cout << "job 7 is paused\n";
              ReportJob(7);
              return 0;
            }),
            0);
  const CommandAnswer answer = AnswerIn(output_);
  EXPECT_TRUE(answer.taken());
  EXPECT_EQ(answer.job(), 7u);
  EXPECT_EQ(answer.code(), "taken");
  EXPECT_EQ(answer.message(), "job 7 is paused");
  EXPECT_EQ(errors_, "");
}

TEST_F(JsonOfCommands, AnAnswerAboutSeveralJobsHasThemAllInTheirOrder) {
  Act([] {
    for (const std::uint32_t job : {7, 9, 8, 9}) ReportJob(job);
    return 0;
  });
  const CommandAnswer answer = AnswerIn(output_);
  EXPECT_EQ(answer.job(), 0u);
  EXPECT_THAT(answer.jobs(), ::testing::ElementsAre(7, 9, 8));
}

// What a command printed past std::cout would stand before the answer.
TEST(TextOfCommands, GoesThroughStdCoutAlone) {
  const std::regex past("fmt::print\\(\\s*\"|std::(printf|puts|fputs)\\(");
  const std::filesystem::path folder = INTAGLIO_SOURCE_DIR "/services/cli";
  std::size_t read = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const bool is_other = entry.path().filename() == "write_schemas.cc";
    if (entry.path().extension() != ".cc" || is_other) continue;
    std::ifstream in(entry.path());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_FALSE(std::regex_search(text, past)) << entry.path();
    ++read;
  }
  EXPECT_GT(read, 100u);
}

TEST_F(JsonOfCommands, SeveralErrorsAreOneObjectAndTheExitCodeIsKept) {
  EXPECT_EQ(Act([] {
              std::cout << "els-03: stopped\n";
              Complain({ErrorCode::kTimedOut, "els-04 has not confirmed", ""});
              return Complain({ErrorCode::kFault, "els-05 has not confirmed", ""}, 4);
            }),
            4);
  const CommandAnswer answer = AnswerIn(output_);
  EXPECT_FALSE(answer.taken());
  EXPECT_EQ(answer.code(), "timed_out");
  EXPECT_EQ(answer.message(),
            "els-03: stopped\nels-04 has not confirmed\nels-05 has not confirmed");
  EXPECT_EQ(errors_, "");
}

TEST_F(JsonOfCommands, AnEndWithoutASentenceHasACodeToo) {
  const std::vector<std::pair<int, std::string>> ends = {
      {1, "fault"}, {2, "invalid_value"}, {3, "not_good"},
      {4, "fault"}, {5, "cancelled"},     {6, "cancelled"}};
  for (const auto& [exit_code, code] : ends) {
    EXPECT_EQ(Act([end = exit_code] { return end; }), exit_code);
    EXPECT_EQ(AnswerIn(output_).code(), code);
    EXPECT_FALSE(AnswerIn(output_).taken());
  }
  EXPECT_EQ(Act([]() -> int { throw std::runtime_error("no memory"); }), 1);
  EXPECT_EQ(AnswerIn(output_).code(), "fault");
  EXPECT_EQ(AnswerIn(output_).message(), "no memory");
}

// A name that is not UTF-8 does not cost the answer.
TEST_F(JsonOfCommands, AnyBytesCanBeAnswered) {
  Act([] { return Complain({ErrorCode::kNotFound, "no file \xff.obj", ""}); });
  EXPECT_EQ(AnswerIn(output_).message(), "no file ?.obj");
}

TEST_F(JsonOfCommands, AMessageOfTheCommandIsNotFollowedByAnother) {
  bool own = false;
  EXPECT_EQ(Run([&](command_line::Command command) {
              command.AddFlag("--json", own, "for programs");
              command.SetAction([] {
                std::cout << "{\"jobs\":[]}";
                return Complain({ErrorCode::kFault, "the disk is full", ""}, 4);
              });
            }),
            4);
  EXPECT_EQ(output_, "{\"jobs\":[]}");
  EXPECT_EQ(errors_, "intaglio: the disk is full\n");
}

TEST_F(JsonOfCommands, ARefusalOfTheJobServiceHasItsCodeAndItsSentence) {
  Act([] {
    return Complain({ErrorCode::kRefused, "refused, superseded: the stop was pressed",
                     client::NameOf(intaglio_ANSWER_SUPERSEDED)},
                    4);
  });
  EXPECT_EQ(AnswerIn(output_).code(), "superseded");
  EXPECT_EQ(AnswerIn(output_).message(), "the stop was pressed");
  EXPECT_EQ(client::RefusalCode({ErrorCode::kRefused, "", "door"}), "refused");
  EXPECT_EQ(client::RefusalCode({ErrorCode::kTimedOut, "", "superseded"}), "timed_out");
}

// One line for a program that reads events, beside the sentence for people.
TEST_F(JsonOfCommands, WithEventsARefusalIsAnEventWithItsCode) {
  bool events = false;
  const auto run = [&](const std::function<void()>& before) {
    return Run(
        [&](command_line::Command command) {
          command.AddFlag("--events", events, "for programs");
          command.SetAction([&] {
            before();
            return Complain({ErrorCode::kNotFound, "no glass N-XX", ""});
          });
        },
        "--events");
  };
  EXPECT_EQ(run([] {}), client::kExitWrongInput);
  JobEvent event;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output_, &event).ok());
  EXPECT_EQ(event.event(), "refused");
  EXPECT_EQ(event.code(), "not_found");
  EXPECT_EQ(event.message(), "no glass N-XX");
  EXPECT_EQ(errors_, "intaglio: no glass N-XX\n");
  run([] { std::cout << "{\"event\":\"submitted\"}\n"; });
  EXPECT_EQ(output_, "{\"event\":\"submitted\"}\n");
}

TEST(CodesOfRefusals, AreInTheDocumentation) {
  std::ifstream in(INTAGLIO_SOURCE_DIR "/docs/cli.md");
  const std::string document{std::istreambuf_iterator<char>(in), {}};
  for (int code = 0; code <= static_cast<int>(ErrorCode::kCancelled); ++code) {
    const std::string name = ErrorCodeName(static_cast<ErrorCode>(code));
    EXPECT_THAT(document, HasSubstr("`" + name + "`"));
  }
  for (int code = intaglio_ANSWER_TAKEN; code <= intaglio_ANSWER_NOT_MOUNTED; ++code) {
    const std::string name =
        client::NameOf(static_cast<intaglio_CommandAnswerCode>(code));
    EXPECT_THAT(document, HasSubstr("`" + name + "`"));
  }
}

}  // namespace
}  // namespace intaglio::cli
