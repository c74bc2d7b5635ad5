#include "services/platform/command_line/line_parse.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "services/platform/command_line/state.h"

namespace intaglio::command_line {
namespace {

/// An option of a command, and the variable of the environment that it reads.
struct Variable {
  CLI::Option* option;
  std::string name;
};

void Restore(const std::vector<Variable>& variables) {
  for (const Variable& variable : variables) variable.option->envname(variable.name);
}

/// Gives the options their variables back, which help and manual pages print.
class Restored {
 public:
  explicit Restored(const std::vector<Variable>& variables) : variables_(variables) {}
  ~Restored() { Restore(variables_); }
  Restored(const Restored&) = delete;
  Restored& operator=(const Restored&) = delete;

 private:
  const std::vector<Variable>& variables_;
};

/// An option of the same name was given behind a command above this one.
bool IsGivenAbove(const CLI::App& command, const CLI::Option& option) {
  for (const CLI::App* app = command.get_parent(); app != nullptr;
       app = app->get_parent()) {
    const CLI::Option* const same = app->get_option_no_throw(option.get_name());
    if (same != nullptr && same->count() > 0) return true;
  }
  return false;
}

/// An option that was given behind a command, and before one below it, is that one's: a
/// value for a command that does not run would be lost without a word.
void PassOptionsDown(CLI::App& app) {
  for (CLI::App* const command : app.get_subcommands()) {
    const bool is_of_command = app.get_parent() != nullptr && !command->get_fallthrough();
    for (const CLI::Option* const given : app.get_options()) {
      if (!is_of_command || given->count() == 0) continue;
      CLI::Option* const own = command->get_option_no_throw(given->get_name());
      if (own == nullptr) {
        throw CLI::ValidationError(given->get_name(),
                                   fmt::format("is an option of {}, and not of {}",
                                               PathOf(app), PathOf(*command)));
      }
      if (own->count() > 0) continue;
      own->add_result(given->results());
      own->run_callback();
    }
    PassOptionsDown(*command);
  }
}

/// All variables of the commands below `app`. A command that is given gets its own back
/// before it is parsed, but for options that were given before it.
std::vector<Variable> VariablesOfCommands(CLI::App& app) {
  std::vector<Variable> all;
  for (CLI::App* const command : app.get_subcommands([](CLI::App*) { return true; })) {
    std::vector<Variable> own;
    for (CLI::Option* const option : command->get_options()) {
      if (const std::string name = option->get_envname(); !name.empty())
        own.push_back({option, name});
    }
    command->preparse_callback([own, command](std::size_t) {
      for (const Variable& variable : own) {
        if (!IsGivenAbove(*command, *variable.option))
          variable.option->envname(variable.name);
      }
    });
    all.insert(all.end(), own.begin(), own.end());
    const std::vector<Variable> below = VariablesOfCommands(*command);
    all.insert(all.end(), below.begin(), below.end());
  }
  return all;
}

}  // namespace

// The library reads the variables of every command's options, also of those that were not
// given. Commands that share their values would so replace an option that was given.
void ParseLine(CLI::App& app, std::vector<std::string> words) {
  const std::vector<Variable> variables = VariablesOfCommands(app);
  const Restored restored(variables);
  for (const Variable& variable : variables) variable.option->envname("");
  std::reverse(words.begin(), words.end());  // the library takes them from the end
  app.parse(std::move(words));
  PassOptionsDown(app);
}

}  // namespace intaglio::command_line
