#pragma once

#include <optional>
#include <string>
#include <vector>

namespace intaglio::command_line {

/// Suggestion for a word on the command line that is not known: the known word that is at
/// most two letters (left out, put in, wrong, or two that changed places) away from
/// `word`, and less than half of it; the nearest, then the first.
std::optional<std::string> NearestName(const std::string& word,
                                       const std::vector<std::string>& known);

}  // namespace intaglio::command_line
