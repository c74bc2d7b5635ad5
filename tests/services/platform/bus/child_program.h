#pragma once

// Another process of a test; killed with its holder.

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::test {

class ChildProgram {
 public:
  ChildProgram(const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    if (posix_spawn(&pid_, argv[0], nullptr, nullptr, argv.data(), environ) != 0)
      pid_ = -1;
  }
  ~ChildProgram() { Kill(); }
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  pid_t pid() const { return pid_; }
  bool running() {
    if (pid_ > 0 && waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
    return pid_ > 0;
  }
  void Signal(int number) {
    if (running()) kill(pid_, number);
  }
  /// As kill -9.
  void Kill() {
    if (!running()) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
    pid_ = -1;
  }
  /// Nothing when it does not end by itself in time.
  std::optional<int> ExitCode(
      std::chrono::milliseconds timeout = std::chrono::seconds(10)) {
    if (!Eventually([this] { return !running(); }, timeout)) return std::nullopt;
    return WIFEXITED(status_) ? std::optional(WEXITSTATUS(status_)) : std::nullopt;
  }

 private:
  pid_t pid_ = -1;
  int status_ = 0;
};

}  // namespace intaglio::test
