#include "services/virtual_engraver/pty_line.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <random>
#include <utility>

#include "services/link/serial_port.h"

namespace intaglio::virtual_engraver {

struct PtyLine::Loss {
  double ratio = 0;
  std::mt19937 random;
};

namespace {

class LossyStream final : public link::ByteStream {
 public:
  LossyStream(std::unique_ptr<link::ByteStream> inner, std::function<bool()> loses)
      : inner_(std::move(inner)), loses_(std::move(loses)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    auto got = inner_->Read(buffer);
    if (!got) return got;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < *got; ++i) {
      if (!loses_()) buffer[kept++] = buffer[i];
    }
    return kept;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
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
  termios settings{};
  cfmakeraw(&settings);
  if (openpty(&line.master_, &line.held_slave_, device.data(), &settings, nullptr) != 0) {
    return CannotOpen(link_path, std::strerror(errno));
  }
  fcntl(line.master_, F_SETFD, FD_CLOEXEC);
  fcntl(line.held_slave_, F_SETFD, FD_CLOEXEC);
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
      held_slave_(std::exchange(other.held_slave_, -1)),
      loss_(std::move(other.loss_)) {}

PtyLine& PtyLine::operator=(PtyLine&& other) noexcept {
  std::swap(link_path_, other.link_path_);
  std::swap(name_, other.name_);
  std::swap(master_, other.master_);
  std::swap(held_slave_, other.held_slave_);
  std::swap(loss_, other.loss_);
  return *this;
}

PtyLine::~PtyLine() {
  std::error_code error;
  if (!link_path_.empty()) std::filesystem::remove(link_path_, error);
  if (held_slave_ >= 0) close(held_slave_);
  if (master_ >= 0) close(master_);
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
