#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "engrave/io/nearest_name.h"
#include "services/platform/command_line/state.h"

namespace intaglio::command_line {
namespace {

// So many other commands are named that have an option.
constexpr std::size_t kMaxCommands = 4;

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

std::vector<const CLI::App*> CommandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<std::string> CommandNamesOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : CommandsOf(app)) names.push_back(command->get_name());
  return names;
}

/// Commands, without the program's name, that have the option.
void FindCommandsWith(const std::string& option, const CLI::App& app,
                      const std::string& path, std::vector<std::string>& found) {
  for (const CLI::App* command : CommandsOf(app)) {
    const std::string name = path + command->get_name();
    const auto options = OptionsOf(*command);
    if (std::find(options.begin(), options.end(), option) != options.end()) {
      found.push_back(name);
    }
    FindCommandsWith(option, *command, name + " ", found);
  }
}

std::string CommandsWith(const std::string& option, const CLI::App& program) {
  std::vector<std::string> found;
  FindCommandsWith(option, program, "", found);
  if (found.empty()) return "";
  const bool more = found.size() > kMaxCommands;
  if (more) found.resize(kMaxCommands);
  return fmt::format(" (an option of {}{})", fmt::join(found, ", "),
                     more ? " and others" : "");
}

std::string DidYouMean(const std::string& word, const std::vector<std::string>& known) {
  const auto meant = io::NearestName(word, known);
  return meant ? fmt::format(", did you mean {}?", *meant) : "";
}

}  // namespace

std::string PathOf(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : PathOf(*parent) + " " + app.get_name();
}

std::string TextOfUnknownArguments(const CLI::App& app) {
  const CLI::App& innermost = InnermostOf(app);
  const std::vector<std::string> words = app.remaining(true);
  if (words.empty() && innermost.get_require_subcommand_min() > 0) {
    return fmt::format("{0} needs a command: {1}; see {0} --help", PathOf(innermost),
                       fmt::join(CommandNamesOf(innermost), ", "));
  }
  if (words.empty()) return "";
  const std::string word = words.front().substr(0, words.front().find('='));
  const std::string path = PathOf(innermost);
  if (word.starts_with("-")) {
    std::string meant = CommandsWith(word, app);
    if (meant.empty()) meant = DidYouMean(word, OptionsOf(innermost));
    return fmt::format("{} has no option '{}'{}; see {} --help", path, word, meant, path);
  }
  const auto commands = CommandNamesOf(innermost);
  return fmt::format("{} {} '{}'{}; see {} --help", path,
                     commands.empty() ? "does not accept" : "has no command", word,
                     DidYouMean(word, commands), path);
}

std::string TextOfUnknownChoice(const std::string& value,
                                const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), value) != choices.end()) return "";
  return fmt::format("'{}' is none of {}{}", value, fmt::join(choices, ", "),
                     DidYouMean(value, choices));
}

const CLI::App* FindCommand(const CLI::App& program,
                            const std::vector<std::string>& words, std::string& why_not) {
  const CLI::App* app = &program;
  for (const std::string& word : words) {
    const auto commands = CommandsOf(*app);
    const auto found =
        std::find_if(commands.begin(), commands.end(),
                     [&](const CLI::App* command) { return command->check_name(word); });
    if (found == commands.end()) {
      why_not = fmt::format("{} has no command '{}'{}; see {} --help", PathOf(*app), word,
                            DidYouMean(word, CommandNamesOf(*app)), PathOf(*app));
      return nullptr;
    }
    app = *found;
  }
  return app;
}

}  // namespace intaglio::command_line
