#pragma once

// The progress of a computation whose parts run at the same time.

#include <atomic>
#include <cstdint>

#include "engrave/core/progress.h"

namespace intaglio {

/// The total progress of several parallel parts, reported to one sink. Any part may make
/// the report.
class SharedProgress {
 public:
  /// `sink` may be empty and has to outlive this.
  SharedProgress(const ProgressSink& sink, std::uint64_t total)
      : sink_(sink), total_(total) {}

  /// Adds `more` units done and returns whether to continue. Of several simultaneous
  /// calls only one calls the sink. May be called from any thread.
  bool GoesOn(std::uint64_t more) {
    done_ += more;
    if (!sink_ || asking_.test_and_set()) return !cancelled_;
    if (!cancelled_ && !sink_(done_, total_)) cancelled_ = true;
    asking_.clear();
    return !cancelled_;
  }
  bool cancelled() const { return cancelled_; }

 private:
  const ProgressSink& sink_;
  std::uint64_t total_;
  std::atomic<std::uint64_t> done_ = 0;
  std::atomic<bool> cancelled_ = false;
  std::atomic_flag asking_;
};

}  // namespace intaglio
