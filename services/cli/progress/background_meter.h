#pragma once

// The progress of a command whose stages do not report at all times: a thread draws what
// was reported last, from the second that the command takes longer than this on. A stage
// without a known share shows how long it takes already.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <iosfwd>
#include <mutex>
#include <string>
#include <thread>

#include "engrave/core/progress.h"
#include "services/cli/progress/progress_bar.h"

namespace intaglio::cli {

class BackgroundMeter {
 public:
  using Clock = std::chrono::steady_clock;

  /// `patience`: what is ready before it has no bar.
  BackgroundMeter(std::ostream& out, bool interactive,
                  Clock::duration patience = std::chrono::seconds(1));
  /// Draws the last state and ends its line.
  ~BackgroundMeter();
  BackgroundMeter(const BackgroundMeter&) = delete;
  BackgroundMeter& operator=(const BackgroundMeter&) = delete;

  /// From now on this stage is shown, its share unknown.
  void Begin(const std::string& stage);
  /// Receives the shares of a stage, which begins with the first of them; always true.
  /// From any thread, while the meter lives.
  ProgressSink Sink(std::string stage);

 private:
  void Run(const std::stop_token& stop);
  void Draw();
  void Enter(const std::string& stage);

  ProgressBar bar_;  // of the thread, and of the destructor behind it
  const Clock::time_point began_ = Clock::now();
  const Clock::duration patience_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::string stage_;
  Clock::time_point stage_began_ = began_;
  std::uint64_t done_ = 0, total_ = 0;
  std::jthread thread_;  // the last member: it uses the others
};

}  // namespace intaglio::cli
