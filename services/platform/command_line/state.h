#pragma once

// What a program keeps beside CLI11's tables; of program.cc and describe.cc alone.

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "engrave/core/result.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace intaglio::command_line {

struct ProgramState {
  std::function<int()> chosen;  ///< action of the command that was given
  std::set<const CLI::App*> with_action;
  std::function<int(const std::function<int()>& action)> runner;  ///< none: a call
  /// Of lines with a flag, by the flag.
  std::map<std::string, std::function<void(const Error&)>> refusals;
  std::map<const CLI::Option*, std::vector<std::string>> choices;
  std::set<std::string> of_several_values;  ///< options of a fixed number of values
  std::vector<std::string> help_command;    ///< of the command `help`
};

/// Text after a command line that the tables do not have: what was typed, what was
/// probably meant, and where to read more. `app`: the program, after its parse failed.
std::string TextOfUnknownArguments(const CLI::App& app);

/// The same for a value that is none of the choices; "" when it is one of them.
std::string TextOfUnknownChoice(const std::string& value,
                                const std::vector<std::string>& choices);

/// "recording info" below the program; nullptr and the text for people when there is no
/// such command.
const CLI::App* FindCommand(const CLI::App& program,
                            const std::vector<std::string>& words, std::string& why_not);

/// "intaglio recording info".
std::string PathOf(const CLI::App& app);

}  // namespace intaglio::command_line
