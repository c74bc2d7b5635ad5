#include "services/drivers/linuxcnc/hal_line.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::drivers {
namespace {

constexpr char kRemedy[] =
    "install LinuxCNC (Debian: linuxcnc-uspace) on this computer, and start the "
    "machine's "
    "HAL with deploy/linuxcnc/start";

/// One of LinuxCNC's programs, and our end of its standard input or output.
class Tool {
 public:
  Tool() = default;
  Tool(pid_t child, int end) : child_(child), end_(end) {}
  Tool(Tool&& other) noexcept
      : child_(std::exchange(other.child_, -1)), end_(std::exchange(other.end_, -1)) {}
  Tool& operator=(Tool&&) = delete;
  ~Tool() {
    if (end_ >= 0) close(end_);
    if (child_ < 0) return;
    // It takes its leave of HAL within a millisecond or two; killed, it would leave its
    // name there.
    kill(child_, SIGTERM);
    for (int i = 0; i < 10; ++i) {
      if (waitpid(child_, nullptr, WNOHANG) == child_) return;
      usleep(1000);
    }
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  int end() const { return end_; }

 private:
  pid_t child_ = -1;
  int end_ = -1;
};

// In the child, after fork: only what is safe there.
[[noreturn]] void Become(const char* const* argv, int theirs, int as) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  const int none = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int standard : {0, 1, 2}) dup2(standard == as ? theirs : none, standard);
  signal(SIGPIPE, SIG_DFL);
  execvp(argv[0], const_cast<char* const*>(argv));
  _exit(127);
}

/// `as`: which of its standard files is at the other end, 0 or 1.
Result<Tool> Start(const char* const* argv, int as) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    return Fail(ErrorCode::kIo, std::string("no pipe to ") + argv[0]);
  const int ours = ends[as == 0 ? 1 : 0], theirs = ends[as == 0 ? 0 : 1];
  const pid_t child = fork();
  if (child == 0) Become(argv, theirs, as);
  close(theirs);
  fcntl(ours, F_SETFL, O_NONBLOCK);
  Tool tool(child, ours);
  if (child < 0) return Fail(ErrorCode::kIo, std::string(argv[0]) + " cannot be started");
  return tool;
}

class Programs final : public HalLine {
 public:
  Programs(Tool rows, Tool commands, Tool samples)
      : rows_(std::move(rows)),
        commands_(std::move(commands)),
        samples_(std::move(samples)) {}
  Status WriteRows(std::string_view lines) override { return Write(rows_, lines); }
  Status WriteCommands(std::string_view lines) override {
    return Write(commands_, lines);
  }
  Result<std::size_t> ReadSamples(std::span<char> buffer) override {
    const ssize_t count = read(samples_.end(), buffer.data(), buffer.size());
    if (count > 0) return static_cast<std::size_t>(count);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return std::size_t{0};
    return Fail(ErrorCode::kLinkLost, std::string("halsampler has ended: ") + kRemedy);
  }
  int fd() const override { return samples_.end(); }

 private:
  // A pipe that is nearly full belongs to a program that hangs: a torn line would be
  // one that means something else, so the line is given up.
  static Status Write(const Tool& tool, std::string_view lines) {
    const ssize_t count = write(tool.end(), lines.data(), lines.size());
    if (count == static_cast<ssize_t>(lines.size())) return {};
    return Fail(ErrorCode::kLinkLost,
                std::string("halstreamer takes no more: ") + kRemedy);
  }

  Tool rows_, commands_, samples_;
};

}  // namespace

Result<std::unique_ptr<HalLine>> OpenHalLine() {
  static constexpr const char* kRows[] = {"halstreamer", "-c", "0", nullptr};
  static constexpr const char* kCommands[] = {"halstreamer", "-c", "1", nullptr};
  static constexpr const char* kSamples[] = {"stdbuf", "-oL", "halsampler", "-c",
                                             "0",      "-t",  nullptr};
  Tool rows = INTAGLIO_TRY(Start(kRows, 0));
  Tool commands = INTAGLIO_TRY(Start(kCommands, 0));
  Tool samples = INTAGLIO_TRY(Start(kSamples, 1));
  return std::make_unique<Programs>(std::move(rows), std::move(commands),
                                    std::move(samples));
}

}  // namespace intaglio::drivers
