#pragma once

// What the tests of the tree read of its files.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace intaglio::walls {

inline const std::filesystem::path kRoot = INTAGLIO_SOURCE_DIR;

/// Empty when it cannot be read.
inline std::string TextOfFile(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The text between the quotes or brackets of an include; empty for any other line.
inline std::string IncludedBy(const std::string& line) {
  const std::string word = "#include ";
  if (!line.starts_with(word) || line.size() < word.size() + 2) return {};
  const auto end = line.find_first_of("\">", word.size() + 1);
  return end == std::string::npos ? ""
                                  : line.substr(word.size() + 1, end - word.size() - 1);
}

}  // namespace intaglio::walls
