#pragma once

// The folders of the product include each other in one direction: a reader of a folder
// has to know those below it, and no other.

#include <filesystem>
#include <string>
#include <vector>

namespace intaglio::walls {

/// One sentence for each two folders of which the second is on a way of includes back to
/// the first, with the first such include by file name. Empty: there is no circle.
std::vector<std::string> FoldersInCircles(const std::filesystem::path& root);

}  // namespace intaglio::walls
