#pragma once

// Functions that no program calls: a function of a header that only tests name is dead
// code with a test. Models that a source's claims are checked with belong to
// tests/published.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace intaglio::walls {

/// Names that a header of the product declares and that nothing in the product uses: all
/// that it has of them are declarations and definitions. Overloads share a name. Sorted,
/// with the header.
std::map<std::string, std::string> UnreachedNames(const std::filesystem::path& root);

/// One sentence for each unreached name without a reason to stay, and for each reason
/// whose name is gone or reached.
std::vector<std::string> UnreachedFunctions(const std::filesystem::path& root);

}  // namespace intaglio::walls
