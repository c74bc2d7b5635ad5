#pragma once

// The files of the tree that the tests of its documents read.

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

}  // namespace intaglio::walls
