#include "services/virtual_engraver/lines/pty_line.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "services/platform/link/serial_port.h"

namespace intaglio::virtual_engraver {

struct PtyLine::Terminal {
  Terminal(std::filesystem::path path, std::string its_name)
      : link_path(std::move(path)), name(std::move(its_name)) {}
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal() {
    std::error_code error;
    if (linked) std::filesystem::remove(link_path, error);
    if (master >= 0) close(master);
  }

  std::filesystem::path link_path;
  std::string name;
  int master = -1;
  bool linked = false;
};

namespace {

bool HostThere(int master) {
  pollfd line{master, 0, 0};
  return poll(&line, 1, 0) >= 0 && (line.revents & POLLHUP) == 0;
}

/// A terminal that no process has open is not a lost line.
class MasterStream final : public link::ByteStream {
 public:
  explicit MasterStream(std::unique_ptr<link::ByteStream> inner)
      : inner_(std::move(inner)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    if (!HostThere(inner_->fd())) return std::size_t{0};
    return inner_->Read(buffer);
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    if (!HostThere(inner_->fd())) return bytes.size();
    return inner_->Write(bytes);
  }
  int fd() const override { return inner_->fd(); }

 private:
  std::unique_ptr<link::ByteStream> inner_;
};

tl::unexpected<Error> CannotOpen(const std::filesystem::path& path,
                                 const std::string& why) {
  return Fail(ErrorCode::kIo,
              fmt::format("cannot make the line {}: {}", path.string(), why),
              path.string());
}

}  // namespace

Result<PtyLine> PtyLine::Open(const std::filesystem::path& link_path,
                              const std::string& name) {
  auto terminal = std::make_unique<Terminal>(link_path, name);
  std::array<char, 256> device{};
  int slave = -1;
  if (openpty(&terminal->master, &slave, device.data(), nullptr, nullptr) != 0) {
    return CannotOpen(link_path, std::strerror(errno));
  }
  close(slave);
  fcntl(terminal->master, F_SETFD, FD_CLOEXEC);
  std::error_code error;
  if (std::filesystem::is_symlink(link_path)) std::filesystem::remove(link_path, error);
  std::filesystem::create_symlink(device.data(), link_path, error);
  if (error) return CannotOpen(link_path, error.message());
  terminal->linked = true;
  return PtyLine(std::move(terminal));
}

PtyLine::PtyLine(std::unique_ptr<Terminal> terminal) : terminal_(std::move(terminal)) {}
PtyLine::PtyLine(PtyLine&&) noexcept = default;
PtyLine& PtyLine::operator=(PtyLine&&) noexcept = default;
PtyLine::~PtyLine() = default;

bool PtyLine::host_there() const { return HostThere(terminal_->master); }
std::string PtyLine::device() const { return terminal_->link_path.string(); }

// A terminal without a host is ready at any time: there is nothing to wait for.
std::array<int, 2> PtyLine::descriptors() const {
  return {host_there() ? terminal_->master : -1, -1};
}

bool PtyLine::HostHasGone() {
  const bool was = std::exchange(host_was_there_, host_there());
  return was && !host_was_there_;
}

std::unique_ptr<link::ByteStream> PtyLine::HostBytes() {
  return std::make_unique<MasterStream>(
      link::WrapDescriptor(dup(terminal_->master), terminal_->name));
}

}  // namespace intaglio::virtual_engraver
