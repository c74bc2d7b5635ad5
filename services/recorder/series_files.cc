#include "services/recorder/series_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace intaglio::recorder {

namespace fs = std::filesystem;

fs::path PathOf(const fs::path& first, std::uint32_t number) {
  if (number <= 1) return first;
  return first.parent_path() / fmt::format("{}-{:04}{}", first.stem().string(), number,
                                           first.extension().string());
}

std::vector<SeriesFile> FilesOf(const fs::path& first) {
  const std::string prefix = first.stem().string() + "-";
  std::vector<SeriesFile> files;
  std::error_code error;
  const fs::path folder = first.has_parent_path() ? first.parent_path() : ".";
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path path = first.parent_path() / entry.path().filename();
    std::uint32_t number = 1;
    if (path != first) {
      const std::string stem = path.stem().string();
      if (path.extension() != first.extension() || !stem.starts_with(prefix)) continue;
      const char* begin = stem.data() + prefix.size();
      const char* end = stem.data() + stem.size();
      const auto [rest, wrong] = std::from_chars(begin, end, number);
      if (wrong != std::errc() || rest != end || number < 2) continue;
    }
    if (!entry.is_regular_file(error)) continue;
    files.push_back({number, path, entry.file_size(error), entry.last_write_time(error)});
  }
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return a.number < b.number; });
  return files;
}

}  // namespace intaglio::recorder
