#pragma once

// The progress of a command that is mostly over at once: a bar from the second that it
// takes longer than this on.

#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <iostream>
#include <string>

#include "services/cli/progress/progress_bar.h"

namespace intaglio::cli {

class LateMeter {
 public:
  LateMeter() : bar_(std::cerr, isatty(STDERR_FILENO) != 0) {}
  ~LateMeter() {
    if (shown_) bar_.Finish();
  }
  LateMeter(const LateMeter&) = delete;
  LateMeter& operator=(const LateMeter&) = delete;

  /// As a ProgressSink of that stage; always true. `things`: what it counts, in the
  /// plural, with their rate; none: shares of its work.
  bool Show(const char* stage, std::uint64_t done, std::uint64_t total,
            const char* things = nullptr) {
    const auto now = Clock::now();
    if (stage != stage_) {
      stage_ = stage;
      stage_began_ = now;
    }
    if (now - began_ < kPatient || (now - last_ < kPeriod && done != total)) return true;
    last_ = now;
    shown_ = true;
    const double elapsed_s = std::chrono::duration<double>(now - stage_began_).count();
    if (things == nullptr) {
      bar_.ShowShare(stage, done, total, elapsed_s);
    } else {
      bar_.CountIn(things);
      bar_.Show(stage, done, total, elapsed_s);
    }
    return true;
  }

 private:
  using Clock = std::chrono::steady_clock;
  // What is ready before this needs no bar.
  static constexpr auto kPatient = std::chrono::seconds(1);
  static constexpr auto kPeriod = std::chrono::milliseconds(100);

  ProgressBar bar_;
  std::string stage_;
  Clock::time_point began_ = Clock::now(), stage_began_ = began_, last_{};
  bool shown_ = false;
};

}  // namespace intaglio::cli
