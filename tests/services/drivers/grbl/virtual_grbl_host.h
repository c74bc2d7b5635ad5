#pragma once

// A host at a virtual grbl, for its tests.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "services/virtual_engraver/mill/virtual_grbl.h"

namespace intaglio::grbl {

/// It sends lines and counts answers.
class VirtualHost {
 public:
  explicit VirtualHost(VirtualGrblOptions options = Grbl11()) : grbl(std::move(options)) {
    Run(0.1);
    read.clear();
  }
  void Run(double seconds) {
    for (double left_us = seconds * 1e6; left_us > 0; left_us -= 100) {
      grbl.Advance(100);
      read += grbl.Read();
    }
  }
  int Count(const std::string& what) const {
    int count = 0;
    for (std::size_t at = read.find(what); at != std::string::npos;
         at = read.find(what, at + 1)) {
      ++count;
    }
    return count;
  }
  /// Whole lines only.
  int answers() const {
    int count = 0;
    for (std::size_t at = 0, end; (end = read.find("\r\n", at)) != std::string::npos;
         at = end + 2) {
      count +=
          read.compare(at, end - at, "ok") == 0 || read.compare(at, 6, "error:") == 0;
    }
    return count;
  }
  /// Waits for the answer; returns it.
  std::string Ask(const std::string& line) {
    read.clear();
    grbl.Write(line + "\n");
    for (int i = 0; i < 200000 && answers() == 0; ++i) Run(0.0001);
    return read.substr(0, read.rfind("\r\n"));
  }
  std::string Status() {
    read.clear();
    grbl.Write("?");
    Run(0.02);
    return read.substr(0, read.find('\r'));
  }
  void UntilIdle() {
    for (int i = 0; i < 100000 && (grbl.state() != VirtualGrbl::State::kIdle ||
                                   !grbl.motion().is_empty());
         ++i) {
      Run(0.001);
    }
    ASSERT_EQ(grbl.state(), VirtualGrbl::State::kIdle);
  }
  /// Character-counted: never more in the buffer than it holds.
  double Stream(const std::vector<std::string>& lines) {
    const double begin = grbl.motion().now_us();
    std::size_t next = 0, acknowledged = 0, in_buffer = 0;
    const std::size_t room = receive_bytes;
    read.clear();
    while (acknowledged < lines.size() && grbl.motion().now_us() < begin + 300e6) {
      while (next < lines.size() && in_buffer + lines[next].size() + 1 <= room) {
        grbl.Write(lines[next] + "\n");
        in_buffer += lines[next++].size() + 1;
      }
      Run(0.0001);
      for (int all = answers(); acknowledged < static_cast<std::size_t>(all);) {
        in_buffer -= lines[acknowledged++].size() + 1;
      }
    }
    return (grbl.motion().now_us() - begin) / 1e6;
  }
  VirtualGrbl grbl;
  std::string read;
  std::size_t receive_bytes = 128;
};

/// 15 blocks of 0.05 mm brake from 27 mm/s.
inline VirtualGrblOptions Quick(VirtualGrblOptions options) {
  options.motion.acceleration_mm_s2 = 500;
  return options;
}

/// Lit for 0.05 mm every 0.1 mm, at 50 mm/s.
inline std::vector<std::string> PulsedLine(int count) {
  std::vector<std::string> lines = {"M4S0", "G90G1F3000"};
  for (int i = 0; i < count; ++i) {
    lines.push_back(fmt::format("G1 X{:.3f} S1000", 0.1 * i + 0.05));
    lines.push_back(fmt::format("G1 X{:.3f} S0", 0.1 * i + 0.1));
  }
  return lines;
}

}  // namespace intaglio::grbl
