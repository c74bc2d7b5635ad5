#include "services/platform/command_line/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>

#include "services/platform/command_line/nearest_name.h"

namespace intaglio::command_line {
namespace {

// The command that was being read: the innermost that was given.
const CLI::App& InnermostOf(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : InnermostOf(*given.back());
}

std::vector<std::string> OptionsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> CommandsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::string PathOf(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : PathOf(*parent) + " " + app.get_name();
}

// After a parse that failed because arguments were left over: names the first of them,
// the likely intention, and where to read more.
std::string TextOfUnknownArguments(const CLI::App& app) {
  const CLI::App& innermost = InnermostOf(app);
  const std::vector<std::string> words = app.remaining(true);
  if (words.empty()) return "";
  const std::string word = words.front().substr(0, words.front().find('='));
  const bool option = word.starts_with("-");
  const auto known = option ? OptionsOf(innermost) : CommandsOf(innermost);
  const auto meant = NearestName(word, known);
  const std::string path = PathOf(innermost);
  const std::string what = option          ? "has no option"
                           : known.empty() ? "does not accept"
                                           : "has no command";
  return fmt::format("{} {} '{}'{}; see {} --help", path, what, word,
                     meant ? fmt::format(", did you mean {}?", *meant) : "", path);
}

}  // namespace

// ---- Options -------------------------------------------------------------------------

Option Option::Require() const {
  option_->required();
  return *this;
}

Option Option::Within(int smallest, int largest) const {
  option_->check(CLI::Range(smallest, largest));
  return *this;
}

Option Option::Within(double smallest, double largest) const {
  option_->check(CLI::Range(smallest, largest));
  return *this;
}

Option Option::Positive() const {
  option_->check(CLI::PositiveNumber);
  return *this;
}

Option Option::OneOf(const std::vector<std::string>& values) const {
  option_->check(CLI::IsMember(values));
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
  return *this;
}

Option Option::TakeValues(int smallest, int largest) const {
  option_->expected(smallest, largest);
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
  return {app_->add_subcommand(name, purpose), chosen_};
}

template <typename T>
Option Command::AddOption(const std::string& names, T& value,
                          const std::string& text) const {
  return Option(app_->add_option(names, value, text));
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
  return Option(app_->add_flag(names, value, text));
}

template Option Command::AddFlag(const std::string&, bool&, const std::string&) const;
template Option Command::AddFlag(const std::string&, int&, const std::string&) const;

Option Command::OptionOf(const std::string& name) const {
  return Option(app_->get_option(name));
}

void Command::SetFooter(const std::string& text) const { app_->footer(text); }
void Command::RequireCommand() const { app_->require_subcommand(1); }
void Command::TakeOptionsOfParent() const { app_->fallthrough(); }

void Command::SetAction(std::function<int()> action) const {
  app_->callback([chosen = chosen_, action = std::move(action)] { *chosen = action; });
}

// ---- Programs ------------------------------------------------------------------------

Program::Program(const std::string& name, const std::string& purpose)
    : app_(std::make_unique<CLI::App>(purpose, name)) {
  app_->require_subcommand(0, 1);
}

Program::~Program() = default;

void Program::SetVersion(const std::string& version) {
  app_->set_version_flag("--version", version);
}

std::optional<int> Program::Parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    std::cerr << TextOfUnknownArguments(*app_) << "\n";
    return kExitMisunderstood;
  } catch (const CLI::ParseError& error) {
    return app_->exit(error) == 0 ? 0 : kExitMisunderstood;
  }
  return std::nullopt;
}

Status Program::Parse(std::vector<std::string> words) {
  std::reverse(words.begin(), words.end());  // the library takes them from the end
  try {
    app_->parse(std::move(words));
  } catch (const CLI::ExtrasError&) {
    return Fail(ErrorCode::kInvalidValue, TextOfUnknownArguments(*app_));
  } catch (const CLI::ParseError& error) {
    return Fail(ErrorCode::kInvalidValue, error.what());
  }
  return {};
}

int Program::Run() const {
  if (chosen_) return chosen_();
  std::cout << app_->help();
  return 0;
}

}  // namespace intaglio::command_line
