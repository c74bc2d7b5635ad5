#pragma once

// A process of our own: started, watched, and ended by its process id.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::client {

class ChildProcess {
 public:
  struct Command {
    std::string name;  ///< for messages, e.g. "sorter"
    std::filesystem::path program;
    std::vector<std::string> arguments;
    std::filesystem::path output_file;  ///< its stdout and stderr
    int nice = 0;                       ///< 0..19: how far all other processes go first
  };

  /// kNotFound when there is no such program; kIo when it cannot be started.
  static Result<ChildProcess> Start(const Command& command);
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  /// Ends it: SIGTERM, and SIGKILL three seconds later.
  ~ChildProcess();

  const std::string& name() const { return command_.name; }
  const Command& command() const { return command_; }
  pid_t pid() const { return pid_; }
  bool running();
  /// Exit code, or 128 + signal, once it has ended.
  std::optional<int> exit_code() const { return exit_code_; }
  void Terminate();
  /// True when it ended within the time.
  bool WaitForEnd(std::chrono::milliseconds timeout);
  /// The last lines of its output, for a message.
  std::string LastOutput(std::size_t max_bytes = 1000) const;

 private:
  ChildProcess(Command command, pid_t pid) : command_(std::move(command)), pid_(pid) {}
  void End();
  Command command_;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

/// The flag that ends a service with this process. It names this process by its id: a
/// process that is killed while it starts a service is no longer the service's parent.
std::string DieWithUs();

}  // namespace intaglio::client
