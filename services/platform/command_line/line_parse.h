#pragma once

// What the library leaves to do where commands are below commands: whose option was
// given, and whose variable of the environment counts.

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace intaglio::command_line {

/// A variable counts for the command that is given, and not where an option of its name
/// was given, also behind a command above: commands share their values. An option behind
/// a command above the one that runs is that one's; where it has none of this name the
/// line is refused, since the value would be lost without a word. Throws CLI::ParseError.
void ParseLine(CLI::App& app, std::vector<std::string> words);

}  // namespace intaglio::command_line
