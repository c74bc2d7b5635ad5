#pragma once

// The recordings in tests/data/recordings.

#include <filesystem>
#include <stdexcept>
#include <string>

#include "services/platform/recording/mcap_reader.h"

namespace intaglio::replayer {

inline std::filesystem::path GoldenFile(const std::string& name) {
  return std::filesystem::path(INTAGLIO_SOURCE_DIR) / "tests/data/recordings" / name;
}

inline recording::McapReader Golden(const std::string& name) {
  auto reader = recording::McapReader::Open(GoldenFile(name));
  if (!reader) throw std::runtime_error(reader.error().message);
  return std::move(*reader);
}

}  // namespace intaglio::replayer
