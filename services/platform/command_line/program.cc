#include "services/platform/command_line/program.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iostream>

#include "engrave/io/number_text.h"
#include "services/platform/command_line/joined_values.h"
#include "services/platform/command_line/line_parse.h"
#include "services/platform/command_line/open_files.h"
#include "services/platform/command_line/shell_files.h"
#include "services/platform/command_line/standard_streams.h"
#include "services/platform/command_line/state.h"

namespace intaglio::command_line {
namespace {

/// Refuses a value that is not `wanted`, in its words. `kind`: as --help shows it.
void CheckNumber(CLI::Option& option, const std::function<bool(double)>& fits,
                 const std::string& wanted, const std::string& kind) {
  option.check(
      [fits, wanted](const std::string& value) {
        const auto number = io::ParseFinite(value);
        return number && fits(*number) ? std::string()
                                       : fmt::format("'{}' is no {}", value, wanted);
      },
      kind);
}

}  // namespace

// ---- Options -------------------------------------------------------------------------

Option Option::Require() const {
  option_->required();
  return *this;
}

Option Option::Within(int smallest, int largest) const {
  CheckNumber(
      *option_,
      [=](double number) {
        return number >= smallest && number <= largest && number == std::floor(number);
      },
      fmt::format("whole number from {} to {}", smallest, largest),
      fmt::format("INT in [{} - {}]", smallest, largest));
  return *this;
}

Option Option::Within(double smallest, double largest) const {
  CheckNumber(
      *option_, [=](double number) { return number >= smallest && number <= largest; },
      fmt::format("number from {} to {}", smallest, largest),
      fmt::format("FLOAT in [{} - {}]", smallest, largest));
  return *this;
}

Option Option::Positive() const {
  CheckNumber(
      *option_, [](double number) { return number > 0; }, "number above 0", "POSITIVE");
  return *this;
}

Option Option::OneOf(const std::vector<std::string>& values) const {
  state_->choices[option_] = values;
  option_->check(
      [values](const std::string& value) { return TextOfUnknownChoice(value, values); },
      fmt::format("{{{}}}", fmt::join(values, ",")));
  return *this;
}

Option Option::Exclude(Option other) const {
  option_->excludes(other.option_);
  return *this;
}

Option Option::Need(Option other) const {
  option_->needs(other.option_);
  return *this;
}

Option Option::TakeValues(int count) const {
  option_->expected(count);
  if (count > 1) {
    for (const std::string& name : option_->get_lnames())
      state_->of_several_values.insert("--" + name);
  }
  return *this;
}

Option Option::TakeValues(int smallest, int largest) const {
  option_->expected(smallest, largest);
  return *this;
}

Option Option::TakeOneAtATime() const {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::SplitAt(char separator) const {
  option_->delimiter(separator);
  return *this;
}

Option Option::ShowDefault() const {
  option_->capture_default_str();
  return *this;
}

Option Option::FromEnvironment(const std::string& variable) const {
  option_->envname(variable);
  return *this;
}

Option Option::Describe(const std::string& text) const {
  option_->description(text);
  return *this;
}

Option Option::Group(const std::string& heading) const {
  option_->group(heading);
  return *this;
}

// ---- Commands ------------------------------------------------------------------------

Command Command::AddCommand(const std::string& name, const std::string& purpose) const {
  return {app_->add_subcommand(name, purpose), state_};
}

template <typename T>
Option Command::AddOption(const std::string& names, T& value,
                          const std::string& text) const {
  return {app_->add_option(names, value, text), state_};
}

template Option Command::AddOption(const std::string&, int&, const std::string&) const;
template Option Command::AddOption(const std::string&, std::uint32_t&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::uint64_t&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, double&, const std::string&) const;
template Option Command::AddOption(const std::string&, std::string&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::filesystem::path&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::optional<std::uint32_t>&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::optional<double>&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::optional<std::string>&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::vector<int>&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::vector<double>&,
                                   const std::string&) const;
template Option Command::AddOption(const std::string&, std::vector<std::string>&,
                                   const std::string&) const;

template <typename T>
Option Command::AddFlag(const std::string& names, T& value,
                        const std::string& text) const {
  return {app_->add_flag(names, value, text), state_};
}

template Option Command::AddFlag(const std::string&, bool&, const std::string&) const;
template Option Command::AddFlag(const std::string&, int&, const std::string&) const;
template Option Command::AddFlag(const std::string&, std::string&,
                                 const std::string&) const;

Option Command::OptionOf(const std::string& name) const {
  return {app_->get_option(name), state_};
}

bool Command::HasOption(const std::string& name) const {
  return app_->get_option_no_throw(name) != nullptr;
}

std::string Command::path() const {
  const CLI::App* const above = app_->get_parent();
  if (above == nullptr) return "";
  const std::string parent = Command(app_->get_parent(), state_).path();
  return parent.empty() ? app_->get_name() : parent + " " + app_->get_name();
}

std::vector<Command> Command::commands() const {
  std::vector<Command> below;
  for (CLI::App* const command : app_->get_subcommands([](CLI::App*) { return true; }))
    below.emplace_back(command, state_);
  return below;
}

bool Command::acts() const { return state_->with_action.contains(app_); }

void Command::SetFooter(const std::string& text) const { app_->footer(text); }
void Command::RequireCommand() const { app_->require_subcommand(1); }
void Command::TakeOptionsOfParent() const { app_->fallthrough(); }

void Command::SetAction(std::function<int()> action) const {
  state_->with_action.insert(app_);
  app_->callback([state = state_, action = std::move(action)] {
    // The innermost command's comes first.
    if (!state->chosen) state->chosen = action;
  });
}

// ---- Programs ------------------------------------------------------------------------

Program::Program(const std::string& name, const std::string& purpose)
    : app_(std::make_unique<CLI::App>(purpose, name)),
      state_(std::make_unique<ProgramState>()) {
  app_->require_subcommand(0, 1);
}

Program::~Program() = default;

void Program::SetVersion(const std::string& version) {
  app_->set_version_flag("--version", version);
}

void Program::SetRefusal(const std::string& flag,
                         std::function<void(const Error&)> refuse) {
  state_->refusals[flag] = std::move(refuse);
}

void Program::SetRunner(std::function<int(const std::function<int()>& action)> runner) {
  state_->runner = std::move(runner);
}

bool Program::IsGiven(const std::string& option) const {
  for (const CLI::App* app = app_.get(); app != nullptr;) {
    const CLI::Option* const own = app->get_option_no_throw(option);
    if (own != nullptr && own->count() > 0) return true;
    const auto given = app->get_subcommands();
    app = given.empty() ? nullptr : given.front();
  }
  return false;
}

void Program::AddHelpCommand() {
  Command help = root().AddCommand("help", "show the help of a command");
  help.AddOption("COMMAND", state_->help_command, "default: the list of the commands");
  help.SetFooter(fmt::format(
      "Example: {0} help recording cut, as {0} recording cut --help", app_->get_name()));
  help.SetAction([this] { return ShowHelp(); });
}

int Program::ShowHelp() const {
  std::string why_not;
  const CLI::App* command = FindCommand(*app_, state_->help_command, why_not);
  if (command == nullptr) {
    std::cerr << why_not << "\n";
    return kExitMisunderstood;
  }
  // The program's own help() would be that of the command `help`, which was given.
  std::cout << command->get_formatter()->make_help(command, PathOf(*command),
                                                   CLI::AppFormatMode::Normal);
  return 0;
}

namespace {

/// `unknown`: what TextOfUnknownArguments has about it, or "".
Error RefusalOf(const CLI::ParseError& error, const std::string& unknown) {
  if (!unknown.empty()) return {ErrorCode::kInvalidValue, unknown, ""};
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  const bool missing = code == CLI::ExitCodes::RequiredError;
  return {missing ? ErrorCode::kMissing : ErrorCode::kInvalidValue, error.what(), ""};
}

}  // namespace

int Program::Refuse(const std::vector<std::string>& words, const Error& error,
                    const std::function<void()>& print) const {
  const auto end = std::find(words.begin(), words.end(), "--");
  const auto given = std::find_if(
      state_->refusals.begin(), state_->refusals.end(), [&](const auto& refusal) {
        return std::find(words.begin(), end, refusal.first) != end;
      });
  if (given == state_->refusals.end())
    print();
  else
    given->second(error);
  return kExitMisunderstood;
}

std::optional<int> Program::Parse(int argc, char** argv) {
  KeepStandardStreams();
  if (argc == 3 && std::string_view(argv[1]) == kWriteShellFiles) {
    const Status written = WriteShellFiles(app_->get_name(), Describe(), argv[2]);
    if (written) return 0;
    std::cerr << app_->get_name() << ": " << written.error().message << "\n";
    return kExitMisunderstood;
  }
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    ParseDivided(words);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app_->exit(error);
    const std::string unknown = UnknownIn(error);
    return Refuse(words, RefusalOf(error, unknown), [&] {
      if (unknown.empty())
        app_->exit(error);
      else
        std::cerr << unknown << "\n";
    });
  }
  if (const Status enough = CheckOpenFiles(); !enough) {
    return Refuse(words, enough.error(), [&] {
      std::cerr << app_->get_name() << ": " << enough.error().message << "\n";
    });
  }
  return std::nullopt;
}

Status Program::Parse(const std::vector<std::string>& words) {
  state_->chosen = nullptr;
  try {
    ParseDivided(words);
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(RefusalOf(error, UnknownIn(error)));
  }
  return {};
}

void Program::ParseDivided(const std::vector<std::string>& words) {
  ParseLine(*app_, DivideJoinedValues(words, state_->of_several_values));
}

// A required option may be missing because it is mistyped: the mistyped one is reported.
std::string Program::UnknownIn(const CLI::Error& error) const {
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  const bool by_unknown =
      code == CLI::ExitCodes::ExtrasError || code == CLI::ExitCodes::RequiredError;
  return by_unknown ? TextOfUnknownArguments(*app_) : "";
}

int Program::Run() const {
  if (state_->chosen && state_->runner) return state_->runner(state_->chosen);
  if (state_->chosen) return state_->chosen();
  std::cout << app_->help();
  return 0;
}

}  // namespace intaglio::command_line
