#pragma once

// Programs of others that judge ours, where they are installed.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace intaglio::post::fixture {

inline bool IsInstalled(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

/// What a command prints, both streams; it has to end with 0.
inline std::string OutputOf(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(
      popen((command + " 2>&1").c_str(), "r"),  // NOLINT(cert-env33-c)
      [](FILE* file) {
        EXPECT_EQ(pclose(file), 0);
        return 0;
      });
  std::string text;
  std::array<char, 4096> chunk{};
  for (std::size_t n = 0; (n = fread(chunk.data(), 1, chunk.size(), pipe.get())) > 0;) {
    text.append(chunk.data(), n);
  }
  return text;
}

}  // namespace intaglio::post::fixture
