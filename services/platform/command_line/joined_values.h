#pragma once

// Several numbers in one word, as people write sizes: 50x50x80, 50,50,80, 50×50×80.

#include <set>
#include <string>
#include <vector>

namespace intaglio::command_line {

/// The words with each "XxYxZ" behind one of these options, or behind its "=", divided
/// into its numbers. A word with a part that is no number stays as it is.
/// options: of several numbers, with their dashes: "--block".
std::vector<std::string> DivideJoinedValues(const std::vector<std::string>& words,
                                            const std::set<std::string>& options);

}  // namespace intaglio::command_line
