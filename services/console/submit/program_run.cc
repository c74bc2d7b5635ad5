#include "services/console/submit/program_run.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>
#include <unistd.h>

#include <atomic>
#include <sstream>
#include <system_error>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/client/child_process.h"
#include "services/client/exit_codes.h"
#include "services/platform/command_line/other_programs.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxOutputBytes = 4 << 20;
constexpr std::string_view kName = "intaglio: ";
/// A stop and a machine's services go first.
constexpr int kNice = 5;

/// Removes a file that nobody reads any more.
struct Scratch {
  fs::path file;
  ~Scratch() {
    std::error_code ignored;
    fs::remove(file, ignored);
  }
};

}  // namespace

ConsoleError RefusalOf(const ProgramEnd& end) {
  google::protobuf::util::JsonParseOptions lenient;
  lenient.ignore_unknown_fields = true;
  ConsoleError refusal;
  for (const std::string& json : end.json) {
    // A CommandAnswer and a JobEvent have these two fields of it.
    ConsoleError read;
    const auto parsed = google::protobuf::util::JsonStringToMessage(json, &read, lenient);
    if (parsed.ok() && !read.code().empty()) refusal = std::move(read);
  }
  if (!refusal.code().empty()) return refusal;
  refusal.set_message(end.text);
  refusal.set_code(ErrorCodeName(end.exit_code == client::kExitWrongInput
                                     ? ErrorCode::kInvalidValue
                                     : ErrorCode::kFault));
  return refusal;
}

ProgramEnd EndOfProgram(int exit_code, const std::string& output) {
  ProgramEnd end;
  end.exit_code = exit_code;
  std::istringstream lines(output);
  std::string object;  // of several lines
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('{') || !object.empty()) {
      object += line + "\n";
      if (!line.starts_with('}') && !(line.starts_with('{') && line.ends_with('}')))
        continue;
      end.json.push_back(std::exchange(object, {}));
      continue;
    }
    if (line.starts_with(kName)) line.erase(0, kName.size());
    if (!line.empty()) end.text += (end.text.empty() ? "" : "\n") + line;
  }
  return end;
}

Result<ProgramEnd> RunIntaglio(std::vector<std::string> words, const fs::path& scratch,
                               std::chrono::milliseconds timeout) {
  static std::atomic<unsigned> runs = 0;
  const Scratch output{scratch / fmt::format(".run-{}-{}.txt", getpid(), ++runs)};
  client::ChildProcess::Command command;
  command.name = words.empty() ? "intaglio" : words.front();
  command.program = command_line::ProgramFolder() / "intaglio";
  command.arguments = std::move(words);
  command.output_file = output.file;
  command.nice = kNice;
  auto child = INTAGLIO_TRY(client::ChildProcess::Start(command));
  if (!child.WaitForEnd(timeout)) {
    return Fail(ErrorCode::kTimedOut,
                fmt::format("intaglio {} has not ended within {} s: send the same again "
                            "with the same id",
                            command.name, timeout.count() / 1000));
  }
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(output.file, kMaxOutputBytes));
  return EndOfProgram(child.exit_code().value_or(1), text);
}

}  // namespace intaglio::console
