#include "services/cli/terminal/command_outcome.h"

#include <algorithm>
#include <iostream>
#include <memory>
#include <sstream>
#include <streambuf>
#include <string>
#include <vector>

#include "engrave/drawing/utf8_characters.h"
#include "proto/console.pb.h"
#include "proto/shop.pb.h"
#include "services/client/event_lines.h"
#include "services/client/exit_codes.h"
#include "services/client/job_view.h"
#include "services/client/refusal_code.h"
#include "services/job/files/json_text.h"
#include "services/job/verdict/verdict.h"
#include "services/platform/bus/bus_option_error.h"

namespace intaglio::cli {
namespace {

struct NoJson {
  const char* command;
  const char* reason;
};

constexpr NoJson kNoJson[] = {
    {"up", "runs until Ctrl-C, and prints what happens meanwhile"},
    {"teach", "is a screen for a person at a terminal"},
    {"proofs", "runs until Ctrl-C, and prints what happens meanwhile"},
    {"recording export", "writes messages, as JSON lines or as a table (--format)"},
    {"record", "becomes the program intaglio-recorder, which runs until Ctrl-C"}};

/// Passes everything on, and knows whether there was anything.
class WatchedBuffer : public std::streambuf {
 public:
  explicit WatchedBuffer(std::streambuf* target) : target_(target) {}
  bool written() const { return written_; }

 private:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return sync();
    written_ = true;
    return target_->sputc(traits_type::to_char_type(c));
  }
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    written_ = written_ || size > 0;
    return target_->sputn(text, size);
  }
  int sync() override { return target_->pubsync(); }

  std::streambuf* target_;
  bool written_ = false;
};

/// std::cout has another buffer while this lives.
class CoutBuffer {
 public:
  explicit CoutBuffer(std::streambuf* buffer) : before_(std::cout.rdbuf(buffer)) {}
  ~CoutBuffer() { std::cout.rdbuf(before_); }
  CoutBuffer(const CoutBuffer&) = delete;
  CoutBuffer& operator=(const CoutBuffer&) = delete;

 private:
  std::streambuf* before_;
};

/// What the command that runs with --json or --events has reported so far.
struct Outcome {
  bool is_of_events = false;
  std::ostringstream text;  ///< for the answer, of a command without a message of its own
  WatchedBuffer watched{std::cout.rdbuf()};
  std::vector<Error> refusals;
  std::vector<std::uint32_t> jobs;
};

Outcome* running = nullptr;  // nullptr: a person reads

class Running {
 public:
  explicit Running(Outcome& outcome) { running = &outcome; }
  ~Running() { running = nullptr; }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
};

std::string WithoutEnd(std::string text) {
  const auto last = text.find_last_not_of(" \n");
  text.resize(last == std::string::npos ? 0 : last + 1);
  return text;
}

/// Names of files may have any bytes, and JSON has UTF-8 alone.
void PrintAnswer(CommandAnswer answer) {
  if (!drawing::CharactersOf(answer.message())) {
    std::string text = answer.message();
    std::replace_if(
        text.begin(), text.end(), [](char c) { return (c & 0x80) != 0; }, '?');
    answer.set_message(text);
  }
  std::cout << JsonTextOf(answer).value() << std::flush;
}

void PrintForPeople(const Error& error) {
  if (!error.message.empty()) std::cerr << "intaglio: " << error.message << "\n";
}

/// The sentence without its code, which is in a member of its own.
std::string SentenceOf(const Error& error) {
  const std::string prefix = "refused, " + client::RefusalCode(error) + ": ";
  return error.message.starts_with(prefix) ? error.message.substr(prefix.size())
                                           : error.message;
}

CommandAnswer RefusalOf(const Error& error) {
  CommandAnswer answer;
  answer.set_code(client::RefusalCode(error));
  answer.set_message(SentenceOf(error));
  return answer;
}

/// The code for an exit code, when the command has reported no error: 3 its result is not
/// good, 5 and 6 a person ended it.
std::string CodeOfEnd(int exit_code) {
  switch (exit_code) {
    case client::kExitGood:
      return client::NameOf(intaglio_ANSWER_TAKEN);
    case client::kExitWrongInput:
      return ErrorCodeName(ErrorCode::kInvalidValue);
    case client::kExitNotGood:
      return VerdictName(VerdictKind::kNotGood);
    case client::kExitCancelled:
    case client::kExitLeft:
      return ErrorCodeName(ErrorCode::kCancelled);
    default:
      return ErrorCodeName(ErrorCode::kFault);
  }
}

CommandAnswer AnswerOf(const Outcome& outcome, int exit_code) {
  CommandAnswer answer;
  if (outcome.jobs.size() == 1) {
    answer.set_job(outcome.jobs.front());
  } else {
    answer.mutable_jobs()->Assign(outcome.jobs.begin(), outcome.jobs.end());
  }
  answer.set_taken(exit_code == client::kExitGood);
  std::string message = WithoutEnd(outcome.text.str());
  for (const Error& error : outcome.refusals)
    message += (message.empty() ? "" : "\n") + SentenceOf(error);
  answer.set_message(WithoutEnd(message));
  answer.set_code(answer.taken() || outcome.refusals.empty()
                      ? CodeOfEnd(exit_code)
                      : client::RefusalCode(outcome.refusals.front()));
  return answer;
}

void PrintEvent(const Error& error) {
  client::EventLines(std::cout).Write(RefusedEventOf(error));
}

/// What main() makes of an exception, with a code.
int RunKeepingExceptions(const std::function<int()>& action) {
  try {
    return action();
  } catch (const bus::NotAllowedError& error) {
    ReportRefusal({ErrorCode::kRefused, error.what(), ""});
    return client::kExitMachine;
  } catch (const bus::BusOptionError& error) {
    ReportRefusal(error.error());
    return client::kExitWrongInput;
  } catch (const std::exception& error) {
    ReportRefusal({ErrorCode::kFault, error.what(), ""});
  }
  return client::kExitInternal;
}

/// `collects`: the command has no message of its own.
int RunForProgram(const std::function<int()>& action, bool collects) {
  Outcome outcome;
  int exit_code = client::kExitGood;
  {
    const Running mark(outcome);
    const CoutBuffer buffer(collects ? outcome.text.rdbuf()
                                     : static_cast<std::streambuf*>(&outcome.watched));
    exit_code = RunKeepingExceptions(action);
  }
  if (!outcome.watched.written()) {
    PrintAnswer(AnswerOf(outcome, exit_code));
  } else {
    for (const Error& error : outcome.refusals) PrintForPeople(error);
  }
  return exit_code;
}

/// Sentences go to people as they come; a command that has written no event ends with one
/// for each error.
int RunForEvents(const std::function<int()>& action) {
  Outcome outcome;
  outcome.is_of_events = true;
  int exit_code = client::kExitGood;
  {
    const Running mark(outcome);
    const CoutBuffer buffer(&outcome.watched);
    exit_code = RunKeepingExceptions(action);
  }
  for (const Error& error : outcome.refusals) PrintEvent(error);
  return exit_code;
}

void AddFlag(const command_line::Command& command, bool& answers) {
  for (const command_line::Command& below : command.commands()) AddFlag(below, answers);
  if (!command.acts() || command.HasOption("--json")) return;
  if (ReasonForNoJson(command.path()) != nullptr) return;
  const auto json =
      command.AddFlag("--json", answers, "what came of it, for programs: CommandAnswer");
  if (command.HasOption("--events")) json.Exclude(command.OptionOf("--events"));
}

}  // namespace

JobEvent RefusedEventOf(const Error& error) {
  JobEvent event;
  event.set_event("refused");
  event.set_code(client::RefusalCode(error));
  event.set_message(SentenceOf(error));
  return event;
}

void ReportRefusal(const Error& error) {
  const bool is_kept = running != nullptr && !running->watched.written();
  if (!is_kept || running->is_of_events) PrintForPeople(error);
  if (is_kept) running->refusals.push_back(error);
}

void AnswerWithText() {
  if (running != nullptr) std::cout.rdbuf(running->text.rdbuf());
}

void ReportJob(std::uint32_t number) {
  if (running == nullptr) return;
  auto& jobs = running->jobs;
  if (std::find(jobs.begin(), jobs.end(), number) == jobs.end()) jobs.push_back(number);
}

const char* ReasonForNoJson(const std::string& command) {
  for (const NoJson& exception : kNoJson) {
    if (command == exception.command) return exception.reason;
  }
  return nullptr;
}

void AnswerInJson(command_line::Program& program) {
  const auto answers = std::make_shared<bool>(false);
  AddFlag(program.root(), *answers);
  program.SetRefusal("--json", [](const Error& error) { PrintAnswer(RefusalOf(error)); });
  program.SetRefusal("--events", [](const Error& error) {
    PrintForPeople(error);
    PrintEvent(error);
  });
  program.SetRunner([&program, answers](const std::function<int()>& action) {
    if (program.IsGiven("--events")) return RunForEvents(action);
    return program.IsGiven("--json") ? RunForProgram(action, *answers) : action();
  });
}

}  // namespace intaglio::cli
