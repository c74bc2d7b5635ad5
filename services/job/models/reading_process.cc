#include "services/job/models/reading_process.h"

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
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "engrave/mesh/files/own_formats.h"
#include "services/job/models/mesh_answer.h"
#include "services/job/models/whole_file.h"
#include "services/platform/command_line/other_programs.h"

extern char** environ;

namespace intaglio::mesh_reader {
namespace {

using mesh::ImportOptions;

constexpr std::size_t kBytesPerSecond = 4'000'000;

/// A file in memory, without a name.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("mesh", MFD_CLOEXEC)) {}
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
void Bound(pid_t process, std::chrono::seconds time, const ImportOptions& options) {
  const auto seconds = static_cast<rlim_t>(time.count());
  const rlimit processor{seconds, seconds + 1}, dump{0, 0};
  (void)prlimit(process, RLIMIT_CPU, &processor, nullptr);
  (void)prlimit(process, RLIMIT_CORE, &dump, nullptr);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // Twice what the largest meshes take (mesh_formats.h), and the libraries.
  constexpr rlim_t kLibraries = rlim_t{1} << 30, kBytesPerTriangle = 500;
  const rlim_t bytes = kLibraries + kBytesPerTriangle * options.max_triangles;
  const rlimit memory{bytes, bytes};
  (void)prlimit(process, RLIMIT_AS, &memory, nullptr);
#else
  (void)options;  // the sanitizers take terabytes of addresses
#endif
}

struct Ended {
  int error = 0;   // it could not be started
  int status = 0;  // of waitpid
};

Ended Await(std::vector<std::string> words, const MemoryFile& input,
            const MemoryFile& output, std::chrono::seconds time,
            const ImportOptions& options) {
  const std::vector<char*> argv = command_line::PointersTo(words);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.descriptor(), 0);
  posix_spawn_file_actions_adddup2(&actions, output.descriptor(), 1);
  posix_spawn_file_actions_addclosefrom_np(&actions, 3);
  Ended ended;
  pid_t process = -1;
  ended.error = posix_spawn(&process, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (ended.error != 0) return ended;
  Bound(process, time, options);
  while (waitpid(process, &ended.status, 0) < 0 && errno == EINTR) {
  }
  return ended;
}

std::string HowItEnded(int status) {
  if (WIFSIGNALED(status)) return strsignal(WTERMSIG(status));
  return fmt::format("exit code {}", WEXITSTATUS(status));
}

Answer Read(const ReadingProcess& reader, std::span<const std::byte> bytes,
            std::string_view extension, const ImportOptions& options,
            std::string_view name) {
  const auto refuse = [&](ErrorCode code, const std::string& why) {
    return Fail(code, fmt::format("{}: {}", name, why), std::string(name));
  };
  const std::string program = reader.program.string();
  MemoryFile input, output;
  if (input.descriptor() < 0 || output.descriptor() < 0 ||
      !WriteAll(input.descriptor(), bytes)) {
    return refuse(ErrorCode::kIo, fmt::format("no memory to send it to {}: {}", program,
                                              std::generic_category().message(errno)));
  }
  const auto time = reader.time + std::chrono::seconds(bytes.size() / kBytesPerSecond);
  std::vector<std::string> words = {program,
                                    "--",
                                    std::string(extension),
                                    std::string(name),
                                    std::to_string(options.max_file_bytes),
                                    std::to_string(options.max_unpacked_ratio),
                                    std::to_string(options.max_triangles)};
  words.insert(words.end(), options.objects.begin(), options.objects.end());
  const Ended ended = Await(std::move(words), input, output, time, options);
  if (ended.error != 0) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{} cannot be read: the program {} cannot be started ({}); "
                            "install it in the folder of the other programs",
                            name, program, std::generic_category().message(ended.error)),
                program);
  }
  const bool too_long = WIFSIGNALED(ended.status) && WTERMSIG(ended.status) == SIGXCPU;
  if (too_long) {
    return refuse(ErrorCode::kTooLarge,
                  fmt::format("reading it took more than {} s of processor time; reduce "
                              "the mesh, or export it as stl",
                              time.count()));
  }
  if (ended.status == 0) {
    if (auto answer = ParseAnswer(ReadAll(output.descriptor())))
      return *std::move(answer);
  }
  return refuse(ErrorCode::kUnreadable,
                fmt::format("it crashed the reader of {} files ({}); the file is "
                            "damaged, export it again, preferably as stl",
                            extension, HowItEnded(ended.status)));
}

}  // namespace

mesh::MeshReader ReadBy(const ReadingProcess& process) {
  return [process](std::span<const std::byte> bytes, std::string_view extension,
                   const ImportOptions& options, std::string_view name) {
    return mesh::IsReadByProcess(extension)
               ? Read(process, bytes, extension, options, name)
               : mesh::ReadOwnFormat(bytes, extension, options, name);
  };
}

}  // namespace intaglio::mesh_reader
