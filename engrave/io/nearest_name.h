#pragma once

#include <optional>
#include <string>
#include <vector>

namespace intaglio::io {

/// Suggestion for a name that is not known, of a command, an option, a field: the known
/// word that is at most two letters (left out, put in, wrong, or two that changed places)
/// away from `word`, and less than half of it; the nearest, then the first.
std::optional<std::string> NearestName(const std::string& word,
                                       const std::vector<std::string>& known);

}  // namespace intaglio::io
