#include "services/platform/link/serial_port.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace intaglio::link {
namespace {

struct Baud {
  std::uint32_t rate;
  speed_t constant;
};
constexpr std::array kBauds = {
    Baud{1200, B1200},       Baud{2400, B2400},       Baud{4800, B4800},
    Baud{9600, B9600},       Baud{19200, B19200},     Baud{38400, B38400},
    Baud{57600, B57600},     Baud{115200, B115200},   Baud{230400, B230400},
    Baud{460800, B460800},   Baud{500000, B500000},   Baud{921600, B921600},
    Baud{1000000, B1000000}, Baud{2000000, B2000000}, Baud{3000000, B3000000},
    Baud{4000000, B4000000}};

class DescriptorStream final : public ByteStream {
 public:
  DescriptorStream(int descriptor, std::string name)
      : descriptor_(descriptor), name_(std::move(name)) {}
  ~DescriptorStream() override { close(descriptor_); }

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    const ssize_t got = read(descriptor_, buffer.data(), buffer.size());
    if (got > 0) return static_cast<std::size_t>(got);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::size_t{0};
    // A raw terminal without bytes may return 0, too: only a hang-up is the end.
    pollfd state{descriptor_, POLLIN, 0};
    if (got == 0 && poll(&state, 1, 0) >= 0 &&
        (state.revents & (POLLHUP | POLLERR)) == 0) {
      return std::size_t{0};
    }
    return Lost();
  }

  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    const ssize_t taken = write(descriptor_, bytes.data(), bytes.size());
    if (taken >= 0) return static_cast<std::size_t>(taken);
    if (errno == EAGAIN || errno == EINTR) return std::size_t{0};
    return Lost();
  }

  int fd() const override { return descriptor_; }

 private:
  tl::unexpected<Error> Lost() const {
    return Fail(
        ErrorCode::kLinkLost,
        fmt::format("the line {} is disconnected: check cable and power of the device",
                    name_),
        name_);
  }
  int descriptor_;
  std::string name_;
};

tl::unexpected<Error> CannotOpen(const std::string& device, const std::string& why) {
  return Fail(
      ErrorCode::kIo,
      fmt::format("cannot open serial device {}: {}; check the profile's device, the "
                  "cable, and that you may use it (group dialout)",
                  device, why),
      device);
}

bool IsPseudoTerminal(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 && major(status.st_rdev) >= 136 &&
         major(status.st_rdev) <= 143;
}

/// Against a second process of ours by a lock, against any other program by the
/// terminal's own flag. A pseudo-terminal would keep the flag after the death of the
/// process that set it, as long as its device holds it.
bool TakeForOneself(int descriptor) {
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) return false;
  if (!IsPseudoTerminal(descriptor)) ioctl(descriptor, TIOCEXCL);
  return true;
}

}  // namespace

std::unique_ptr<ByteStream> WrapDescriptor(int descriptor, const std::string& name) {
  fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  return std::make_unique<DescriptorStream>(descriptor, name);
}

Result<std::unique_ptr<ByteStream>> OpenSerialPort(const std::string& device,
                                                   std::uint32_t baud) {
  const Baud* chosen = nullptr;
  for (const Baud& known : kBauds) {
    if (known.rate == baud) chosen = &known;
  }
  if (chosen == nullptr) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("baud {} of {} is not a standard rate, e.g. 115200", baud, device),
        fmt::format("{}", baud));
  }
  const int descriptor = open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return CannotOpen(device, std::strerror(errno));
  auto stream = WrapDescriptor(descriptor, device);
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) {
    return CannotOpen(device, "it is not a terminal device");
  }
  if (!TakeForOneself(descriptor)) {
    return CannotOpen(device, "another process has it");
  }
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  cfsetspeed(&settings, chosen->constant);
  if (tcsetattr(descriptor, TCSANOW, &settings) != 0) {
    return CannotOpen(device, std::strerror(errno));
  }
  tcflush(descriptor, TCIFLUSH);
  return stream;
}

}  // namespace intaglio::link
