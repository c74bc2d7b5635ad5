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

/// The option of that name of the command that was given; nullptr: none.
const CLI::Option* FindGiven(const CLI::App& app, const std::string& name) {
  for (const CLI::App* const command : app.get_subcommands()) {
    if (const CLI::Option* const option = FindGiven(*command, name)) return option;
  }
  return app.get_option_no_throw(name);
}

/// The library's "Could not convert: --block = a,b,c" as a sentence about the option.
CLI::ValidationError ReadableError(const CLI::App& app,
                                   const CLI::ConversionError& error) {
  const std::string text = error.what();
  const std::size_t colon = text.find(": "), equals = text.find(" = ");
  if (colon == std::string::npos || equals == std::string::npos || equals < colon)
    return CLI::ValidationError(text);
  const std::string name = text.substr(colon + 2, equals - colon - 2);
  const CLI::Option* const option = FindGiven(app, name);
  const std::string kind = option == nullptr ? "" : option->get_type_name();
  const bool is_whole = kind.find("INT") != std::string::npos;
  return CLI::ValidationError(
      name,
      fmt::format("'{}' cannot be read as {}", text.substr(equals + 3),
                  option != nullptr && option->get_items_expected_max() > 1 ? "numbers"
                  : is_whole ? "a whole number"
                             : "a number"));
}

/// A value from the environment is named by its variable: no option was written.
CLI::ValidationError NamedByVariable(const std::vector<Variable>& variables,
                                     const std::vector<std::string>& words,
                                     const CLI::ValidationError& error) {
  const std::string text = error.what();
  for (const Variable& variable : variables) {
    const std::string option = variable.option->get_name();
    const bool is_given = std::ranges::any_of(words, [&](const std::string& word) {
      return word == option || word.starts_with(option + "=");
    });
    if (!is_given && text.starts_with(option + ": "))
      return CLI::ValidationError(variable.name, text.substr(option.size() + 2));
  }
  return error;
}

}  // namespace

// The library reads the variables of every command's options, also of those that were not
// given. Commands that share their values would so replace an option that was given.
void ParseLine(CLI::App& app, std::vector<std::string> words) {
  const std::vector<Variable> variables = VariablesOfCommands(app);
  const Restored restored(variables);
  for (const Variable& variable : variables) variable.option->envname("");
  std::reverse(words.begin(), words.end());  // the library takes them from the end
  try {
    app.parse(std::vector<std::string>(words));
  } catch (const CLI::ValidationError& error) {
    throw NamedByVariable(variables, words, error);
  } catch (const CLI::ConversionError& error) {
    throw ReadableError(app, error);
  }
  PassOptionsDown(app);
}

}  // namespace intaglio::command_line
