#pragma once

// The names of the files of a series: NAME.mcap, NAME-0002.mcap, NAME-0003.mcap.

#include <cstdint>
#include <filesystem>
#include <vector>

namespace intaglio::recorder {

struct SeriesFile {
  std::uint32_t number = 0;  ///< from 1
  std::filesystem::path path;
  std::uint64_t bytes = 0;
  std::filesystem::file_time_type written;
};

std::filesystem::path PathOf(const std::filesystem::path& first, std::uint32_t number);
/// Those that are there, by number.
std::vector<SeriesFile> FilesOf(const std::filesystem::path& first);

}  // namespace intaglio::recorder
