#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace intaglio::backup {

/// Empty for a file that cannot be read.
inline std::string BytesIn(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Makes its folder.
inline void PutBytes(const std::filesystem::path& file, const std::string& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace intaglio::backup
