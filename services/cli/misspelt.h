#pragma once

// What is said to somebody who typed a word that nobody knows.

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace intaglio::cli {

/// The known word that is at most two letters (left out, put in, wrong, or two that
/// changed places) away from `word`, and less than half of it; the nearest, then the
/// first.
std::optional<std::string> NearestWord(const std::string& word,
                                       const std::vector<std::string>& known);

/// After a parse that failed over words that were left: names the first of them, what was
/// probably meant, and where to look.
std::string TextOfUnknownWords(const CLI::App& app);

}  // namespace intaglio::cli
