#include "services/client/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <thread>

#include "services/platform/command_line/other_programs.h"

extern char** environ;

namespace intaglio::client {
namespace {
using namespace std::chrono_literals;
namespace fs = std::filesystem;
constexpr auto kTerminateTimeout = 3s;
constexpr auto kPollPeriod = 10ms;
}  // namespace

std::string DieWithUs() { return fmt::format("--die-with-parent={}", getpid()); }

Result<ChildProcess> ChildProcess::Start(const Command& command) {
  if (access(command.program.c_str(), X_OK) != 0) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("the program {} does not exist: build or install it",
                            command.program.string()),
                command.program.string());
  }
  std::vector<std::string> words = {command.program.string()};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  const std::vector<char*> argv = command_line::PointersTo(words);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, command.output_file.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  // A process group of its own: Ctrl-C on the terminal is ours to answer, in order.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t pid = -1;
  const int error =
      posix_spawn(&pid, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    return Fail(ErrorCode::kIo,
                fmt::format("cannot start {}: {}", command.program.string(),
                            std::strerror(error)));
  }
  // It has ended already if this fails.
  if (command.nice > 0)
    (void)setpriority(PRIO_PROCESS, static_cast<id_t>(pid), command.nice);
  return ChildProcess(command, pid);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : command_(std::move(other.command_)),
      pid_(std::exchange(other.pid_, -1)),
      exit_code_(other.exit_code_) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  if (this != &other) {
    End();
    command_ = std::move(other.command_);
    pid_ = std::exchange(other.pid_, -1);
    exit_code_ = other.exit_code_;
  }
  return *this;
}

ChildProcess::~ChildProcess() { End(); }

void ChildProcess::End() {
  if (!running()) return;
  Terminate();
  if (WaitForEnd(kTerminateTimeout)) return;
  kill(pid_, SIGKILL);
  WaitForEnd(kTerminateTimeout);
}

bool ChildProcess::running() {
  if (pid_ <= 0 || exit_code_) return false;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return false;
}

void ChildProcess::Terminate() {
  if (running()) kill(pid_, SIGTERM);
}

bool ChildProcess::WaitForEnd(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (running()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(kPollPeriod);
  }
  return true;
}

std::string ChildProcess::LastOutput(std::size_t max_bytes) const {
  std::ifstream in(command_.output_file, std::ios::binary | std::ios::ate);
  if (!in) return {};
  const auto size = static_cast<std::size_t>(in.tellg());
  const std::size_t count = std::min(size, max_bytes);
  in.seekg(static_cast<std::streamoff>(size - count));
  std::string text(count, '\0');
  in.read(text.data(), static_cast<std::streamsize>(count));
  return text;
}

}  // namespace intaglio::client
