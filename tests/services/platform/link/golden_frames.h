#pragma once

// The golden bytes of every frame, as text.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <span>
#include <string>

#include "tests/services/platform/link/sample_frames.h"

namespace intaglio::link {

inline std::string Hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

/// Frames by name, in hex.
inline std::map<std::string, std::string> Golden(const char* of = "link_frames.golden") {
  std::ifstream file(fmt::format("{}/tests/data/{}", INTAGLIO_SOURCE_DIR, of));
  std::map<std::string, std::string> golden;
  for (std::string name, hex; file >> name >> hex;) golden[name] = hex;
  return golden;
}

inline Bytes BytesOf(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes.push_back(std::byte(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

/// The payload of the only frame in the golden bytes of `name`.
inline Bytes PayloadOf(const std::string& name) {
  Bytes found;
  FrameParser().Feed(BytesOf(Golden().at(name)),
                     [&](const FrameHeader& header, auto payload) {
                       EXPECT_EQ(header.session, 0xDEADBEEFu);
                       found.assign(payload.begin(), payload.end());
                     });
  return found;
}

}  // namespace intaglio::link
