#pragma once

// Headers that are compiled ahead hide an include that a source lacks: it compiles in one
// build and not in another, e.g. not with a compiler cache that does without them.

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::walls {

/// One sentence for each .h and .cc below the folders of `root` that have code, and each
/// header compiled ahead (CMakeLists.txt, COMMON_HEADERS) whose names it uses while
/// neither it nor what it includes of this tree includes that header. Names in comments
/// and texts do not count.
std::vector<std::string> MissingIncludes(const std::filesystem::path& root);

}  // namespace intaglio::walls
