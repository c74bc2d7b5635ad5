#pragma once

// Every parser of bytes from outside has a fuzz target.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace intaglio::walls {

/// The parsers that headers below engrave/, materials_db/, proto/ and services/ declare,
/// with their header: functions whose names begin with Parse, Read, Decode, Import or
/// Unpack, whose first parameter is a text or bytes, and that return a Result or an
/// optional.
std::map<std::string, std::string> DeclaredParsers(const std::filesystem::path& root);

/// What no fuzz target of tests/fuzz calls, neither itself nor by a caller that is
/// listed, and entries of the list that are out of date: a sentence each.
std::vector<std::string> UnfuzzedParsers(const std::filesystem::path& root);

}  // namespace intaglio::walls
