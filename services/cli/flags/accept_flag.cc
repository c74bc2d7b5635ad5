#include "services/cli/flags/accept_flag.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include "engrave/core/try.h"
#include "engrave/core/warning.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::cli {
namespace {

constexpr std::string_view kUp = "up=", kUnit = "unit=";

constexpr std::array kAnswers = {"up=z",      "up=y",      "up=x",      "up=-z",
                                 "up=-y",     "up=-x",     "unit=1",    "unit=10",
                                 "unit=25.4", "unit=1000", "unit=0.001"};

constexpr const char* kWarningText =
    "accept a warning that keeps a job from being armed: breakage, the glass may break; "
    "your name is kept with the job";
constexpr const char* kAnswerText =
    "answer what a preview asks, once for each answer: up=AXIS as --up, unit=MM as "
    "--unit";

std::string Breakage() { return WarningCodeName(WarningCode::kBreakage); }

void Add(command_line::Command command, AcceptFlag& flag, const std::string& text,
         std::vector<std::string> words, bool answers) {
  if (answers) words.insert(words.end(), kAnswers.begin(), kAnswers.end());
  command.AddOption("--accept", flag.given, text).TakeOneAtATime().OneOf(words);
}

template <typename T>
Status Answer(std::optional<T>& option, const T& value, const std::string& word) {
  if (option && *option != value) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("--accept {}: another value is given, too; give one of them", word),
        word);
  }
  option = value;
  return {};
}

}  // namespace

bool AcceptFlag::breakage() const { return std::ranges::count(given, Breakage()) > 0; }

std::optional<Error> WhyRefused(const client::JobView& job, const AcceptFlag& flag) {
  const Warning* consent = job.open_consent();
  if (consent == nullptr || flag.breakage()) return std::nullopt;
  return Error{ErrorCode::kRefused,
               fmt::format("not engraved: {}; to engrave it all the same, give {}",
                           consent->text, AcceptOption(*consent)),
               ""};
}

Status TakeAnswers(const AcceptFlag& flag, JobFlags& job) {
  for (const std::string& word : flag.given) {
    if (word.starts_with(kUp)) {
      INTAGLIO_TRY(Answer(job.up, word.substr(kUp.size()), word));
    } else if (word.starts_with(kUnit)) {
      const double unit_mm = std::strtod(word.c_str() + kUnit.size(), nullptr);
      INTAGLIO_TRY(Answer(job.unit_mm, unit_mm, word));
    }
  }
  return {};
}

void AddAcceptFlag(command_line::Command command, AcceptFlag& flag) {
  Add(command, flag, kWarningText, {Breakage()}, false);
}

void AddAcceptAndAnswers(command_line::Command command, AcceptFlag& flag) {
  Add(command, flag, fmt::format("{}. Or {}", kWarningText, kAnswerText), {Breakage()},
      true);
}

void AddAnswers(command_line::Command command, AcceptFlag& flag) {
  Add(command, flag, kAnswerText, {}, true);
}

}  // namespace intaglio::cli
