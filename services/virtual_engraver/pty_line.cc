#include "services/virtual_engraver/pty_line.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <random>
#include <utility>

#include "services/platform/link/serial_port.h"

namespace intaglio::virtual_engraver {

struct PtyLine::Loss {
  double ratio = 0;
  std::mt19937 random;
};

namespace {

bool HostThere(int master) {
  pollfd line{master, 0, 0};
  return poll(&line, 1, 0) >= 0 && (line.revents & POLLHUP) == 0;
}

class LossyStream final : public link::ByteStream {
 public:
  LossyStream(std::unique_ptr<link::ByteStream> inner, std::function<bool()> loses)
      : inner_(std::move(inner)), loses_(std::move(loses)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    if (!HostThere(inner_->fd())) return std::size_t{0};
    auto got = inner_->Read(buffer);
    if (!got) return got;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < *got; ++i) {
      if (!loses_()) buffer[kept++] = buffer[i];
    }
    return kept;
  }
  // Nobody listens: the bytes leave the machine all the same.
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    if (!HostThere(inner_->fd())) return bytes.size();
    return inner_->Write(bytes);
  }
  int fd() const override { return inner_->fd(); }

 private:
  std::unique_ptr<link::ByteStream> inner_;
  std::function<bool()> loses_;
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
  PtyLine line;
  line.link_path_ = link_path;
  line.name_ = name;
  line.loss_ = std::make_shared<Loss>();
  std::array<char, 256> device{};
  int slave = -1;
  if (openpty(&line.master_, &slave, device.data(), nullptr, nullptr) != 0) {
    return CannotOpen(link_path, std::strerror(errno));
  }
  close(slave);
  fcntl(line.master_, F_SETFD, FD_CLOEXEC);
  std::error_code error;
  if (std::filesystem::is_symlink(link_path)) std::filesystem::remove(link_path, error);
  std::filesystem::create_symlink(device.data(), link_path, error);
  if (error) return CannotOpen(link_path, error.message());
  return line;
}

PtyLine::PtyLine(PtyLine&& other) noexcept
    : link_path_(std::exchange(other.link_path_, {})),
      name_(std::move(other.name_)),
      master_(std::exchange(other.master_, -1)),
      host_was_there_(other.host_was_there_),
      loss_(std::move(other.loss_)) {}

PtyLine& PtyLine::operator=(PtyLine&& other) noexcept {
  std::swap(link_path_, other.link_path_);
  std::swap(name_, other.name_);
  std::swap(master_, other.master_);
  std::swap(host_was_there_, other.host_was_there_);
  std::swap(loss_, other.loss_);
  return *this;
}

PtyLine::~PtyLine() {
  std::error_code error;
  if (!link_path_.empty()) std::filesystem::remove(link_path_, error);
  if (master_ >= 0) close(master_);
}

bool PtyLine::host_there() const { return HostThere(master_); }

bool PtyLine::HostHasGone() {
  const bool was = std::exchange(host_was_there_, host_there());
  return was && !host_was_there_;
}

std::unique_ptr<link::ByteStream> PtyLine::MachineEnd() {
  return std::make_unique<LossyStream>(
      link::WrapDescriptor(dup(master_), name_), [loss = loss_] {
        return loss->ratio > 0 &&
               std::uniform_real_distribution<double>(0, 1)(loss->random) < loss->ratio;
      });
}

void PtyLine::DropBytes(double ratio, unsigned seed) {
  loss_->ratio = ratio;
  loss_->random.seed(seed);
}

}  // namespace intaglio::virtual_engraver
