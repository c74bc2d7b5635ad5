#pragma once

// The commands of a program and their options as data: what --help prints, for man pages,
// completion and tests.

#include <string>
#include <vector>

namespace intaglio::command_line {

struct OptionDescription {
  std::vector<std::string> names;    ///< "--mesh", "--model"; of a positional one "JOB"
  std::string meaning;               ///< one phrase
  std::string group;                 ///< heading in --help
  std::string value;                 ///< kind of value, "FLOAT"; "" of a flag
  std::vector<std::string> choices;  ///< the only values; none: any of that kind
  std::string default_value;         ///< as --help shows it; "": none
  std::string variable;              ///< of the environment; "": none
  bool positional = false;
  bool required = false;
  bool repeatable = false;  ///< takes any number of values
};

struct CommandDescription {
  std::vector<std::string> words;  ///< {"recording", "info"}; of the program: none
  std::string purpose;             ///< one phrase
  std::string footer;              ///< examples, exit codes
  bool acts = false;               ///< false: it only has commands below it
  std::vector<OptionDescription> options;    ///< also those of the command above it takes
  std::vector<CommandDescription> commands;  ///< in the order of --help
};

}  // namespace intaglio::command_line
