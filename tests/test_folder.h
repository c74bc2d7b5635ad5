#pragma once

// Folders of tests, below the build tree. Cases run side by side, each in a process of
// its own, so a folder that two cases share would be emptied while the other case uses
// it.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace intaglio::test {

/// An empty folder of this name: for files made for several cases, or outside of any
/// case.
inline std::filesystem::path FreshFolder(const std::filesystem::path& name) {
  std::filesystem::path folder = std::filesystem::path(INTAGLIO_TEST_DIR) / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

/// An empty folder of the running case's own.
inline std::filesystem::path FreshFolder() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  return FreshFolder(std::filesystem::path(info->test_suite_name()) / info->name());
}

inline std::string ContentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::size_t FileCountIn(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), {}));
}

}  // namespace intaglio::test
