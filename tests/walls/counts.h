#pragma once

// A number that people read agrees with its noun: "1 point", "2 points". Counted and
// GroupedCount do that; a format string that has "{} points" prints "1 points" one day.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace intaglio::walls {

/// The counts before a noun in plural in the string literals of a source, e.g.
/// "{} points", with the number of the line where the literal begins: "12: {} points".
/// Left out are literals of Require, which only programmers read, sizes ("{} x {}
/// nodes"), and counts that the same sentence compares with a limit: they are above one.
std::vector<std::string> BareCounts(std::string_view source);

/// One sentence for each bare count in the .h and .cc of the product that is not
/// excepted, with its reason, in counts.cc; and one for each exception that nothing
/// needs.
std::vector<std::string> BareCountsBelow(const std::filesystem::path& root);

}  // namespace intaglio::walls
