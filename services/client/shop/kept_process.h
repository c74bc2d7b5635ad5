#pragma once

// A process of ours that is started again when it ends by itself, unless it does so again
// and again.

#include <chrono>
#include <deque>
#include <optional>
#include <string>

#include "services/client/child_process.h"

namespace intaglio::client {

/// What is known of an ended process: its exit code and its last output.
Error EndOf(const ChildProcess& process);

class KeptProcess {
 public:
  static Result<KeptProcess> Start(const ChildProcess::Command& command);

  ChildProcess& process() { return process_; }
  /// A sentence when it had ended and was started again; nullopt: it runs. kFault with
  /// its last output at the fifth end within a minute, or when it cannot be started.
  Result<std::optional<std::string>> Revive(std::chrono::steady_clock::time_point now);

 private:
  explicit KeptProcess(ChildProcess process) : process_(std::move(process)) {}
  ChildProcess process_;
  std::deque<std::chrono::steady_clock::time_point> ends_;
};

}  // namespace intaglio::client
