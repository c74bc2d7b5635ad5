#include "services/job/reading/file_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "services/job/reading/whole_file.h"
#include "services/platform/command_line/other_programs.h"

extern char** environ;

namespace intaglio::reading {
namespace {

/// A file in memory, without a name.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("file", MFD_CLOEXEC)) {}
  ~MemoryFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// Limits of the process. A process that may not set them goes on without: they are one
/// protection behind others.
void Bound(pid_t id, const FileProcess& process) {
  const auto seconds = static_cast<rlim_t>(process.time.count());
  const rlimit processor{seconds, seconds + 1}, dump{0, 0};
  (void)prlimit(id, RLIMIT_CPU, &processor, nullptr);
  (void)prlimit(id, RLIMIT_CORE, &dump, nullptr);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // The sanitizers take terabytes of addresses.
  const rlimit memory{process.memory_bytes, process.memory_bytes};
  (void)prlimit(id, RLIMIT_AS, &memory, nullptr);
#endif
}

struct Ended {
  int error = 0;   // it could not be started
  int status = 0;  // of waitpid
};

Ended Await(FileProcess& process, const MemoryFile& input, const MemoryFile& output) {
  const std::vector<char*> argv = command_line::PointersTo(process.words);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.descriptor(), 0);
  posix_spawn_file_actions_adddup2(&actions, output.descriptor(), 1);
  posix_spawn_file_actions_addclosefrom_np(&actions, 3);
  Ended ended;
  pid_t id = -1;
  ended.error = posix_spawn(&id, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (ended.error != 0) return ended;
  Bound(id, process);
  while (waitpid(id, &ended.status, 0) < 0 && errno == EINTR) {
  }
  return ended;
}

}  // namespace

Result<ProcessEnd> RunOnFile(FileProcess process, std::span<const std::byte> file,
                             std::string_view name) {
  const std::string program = process.words.at(0);
  MemoryFile input, output;
  if (input.descriptor() < 0 || output.descriptor() < 0 ||
      !WriteAll(input.descriptor(), file)) {
    return Fail(ErrorCode::kIo,
                fmt::format("{}: no memory to send it to {}: {}", name, program,
                            std::generic_category().message(errno)),
                std::string(name));
  }
  const Ended ended = Await(process, input, output);
  if (ended.error != 0) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{} cannot be read: the program {} cannot be started ({}); "
                            "install it in the folder of the other programs",
                            name, program, std::generic_category().message(ended.error)),
                program);
  }
  ProcessEnd end;
  if (WIFSIGNALED(ended.status)) {
    end.is_too_long = WTERMSIG(ended.status) == SIGXCPU;
    end.reason = strsignal(WTERMSIG(ended.status));
  } else {
    end.exit_code = WEXITSTATUS(ended.status);
    end.reason = fmt::format("exit code {}", end.exit_code);
  }
  end.output = ReadAll(output.descriptor());
  return end;
}

}  // namespace intaglio::reading
