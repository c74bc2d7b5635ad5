#pragma once

// The walls of the source tree: who may include whom, and how long a file may be.
// docs/architecture.md says why.

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::walls {

/// One sentence a violation, beginning with the file. Looks at every .h and .cc below the
/// product's folders of `root`, and at every CMakeLists.txt: one source a line, and no
/// line longer than 100 characters.
std::vector<std::string> Violations(const std::filesystem::path& root);

}  // namespace intaglio::walls
