#pragma once

// The stage's controller in a thread of its own, so that its steps do not wait for the
// laser's ticks. While it moves, the thread keeps a core of the processor busy.

#include <atomic>
#include <string>
#include <thread>

#include "services/reference_controller/host_line.h"
#include "services/reference_controller/stage_controller.h"

namespace intaglio::reference_controller {

class StageThread {
 public:
  /// From now on `controller` and `line`, which outlive this, belong to the thread, but
  /// for StageController::ReceiveTick.
  StageThread(StageController& controller, HostLine& line, ControllerTime time);
  ~StageThread() { Stop(); }
  StageThread(const StageThread&) = delete;
  StageThread& operator=(const StageThread&) = delete;

  /// The board has failed, and all outputs are off.
  bool has_failed() const { return failed_; }
  /// A motion is braked, then all outputs are off. Returns the error of the board; empty:
  /// none.
  std::string Stop();

 private:
  void Run(const std::stop_token& stop);
  void BrakeToRest();

  StageController& controller_;
  HostLine& line_;
  ControllerTime time_;
  std::atomic<bool> failed_{false};
  std::string error_;
  std::jthread thread_;
};

}  // namespace intaglio::reference_controller
