#include "services/platform/link/serial_port.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <vector>

namespace intaglio::link {
namespace {

using ::testing::HasSubstr;

/// A pseudo-terminal: the device's end and the path of the host's.
class Pty {
 public:
  Pty() {
    std::array<char, 256> path{};
    // Held open, so that the device's end does not hang up before the host opens its own.
    if (openpty(&device_, &held_, path.data(), nullptr, nullptr) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    path_ = path.data();
  }
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;
  ~Pty() { Unplug(); }

  void Unplug() {
    for (int* fd : {&device_, &held_}) {
      if (*fd >= 0) close(*fd);
      *fd = -1;
    }
  }
  const std::string& path() const { return path_; }
  int device() const { return device_; }
  termios Settings() const {
    termios settings{};
    tcgetattr(held_, &settings);
    return settings;
  }

 private:
  int device_ = -1, held_ = -1;
  std::string path_;
};

/// Reads until `size` bytes are in or nothing comes for a second.
std::vector<std::byte> ReadAll(ByteStream& stream, std::size_t size) {
  std::vector<std::byte> all;
  std::array<std::byte, 300> buffer;
  pollfd state{stream.fd(), POLLIN, 0};
  while (all.size() < size && poll(&state, 1, 1000) > 0) {
    const auto got = stream.Read(buffer);
    if (!got) break;
    all.insert(all.end(), buffer.begin(),
               buffer.begin() + static_cast<std::ptrdiff_t>(*got));
  }
  return all;
}

std::vector<std::byte> EveryByte() {
  std::vector<std::byte> bytes(256);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::byte(i);
  return bytes;
}

// A terminal that is not raw would eat, echo or change some of the 256.
TEST(SerialPort, CarriesEveryByteBothWaysUnchanged) {
  Pty pty;
  auto port = OpenSerialPort(pty.path(), 115200);
  ASSERT_TRUE(port) << port.error().message;
  const auto device = WrapDescriptor(dup(pty.device()), "device");
  EXPECT_EQ((*port)->Write(EveryByte()), 256u);
  EXPECT_EQ(ReadAll(*device, 256), EveryByte());
  EXPECT_EQ(device->Write(EveryByte()), 256u);
  EXPECT_EQ(ReadAll(**port, 256), EveryByte());
}

TEST(SerialPort, NeverBlocks) {
  Pty pty;
  auto port = OpenSerialPort(pty.path(), 115200);
  ASSERT_TRUE(port);
  std::array<std::byte, 4096> buffer{};
  EXPECT_EQ((*port)->Read(buffer), 0u);
  // No process reads: at some time the line takes nothing more, and reports it.
  bool full = false;
  for (int i = 0; i < 10000 && !full; ++i) full = (*port)->Write(buffer) == 0u;
  EXPECT_TRUE(full);
}

TEST(SerialPort, ForgetsWhatWasReportedBeforeItWasOpened) {
  Pty pty;
  ASSERT_EQ(write(pty.device(), "old\n", 4), 4);
  auto port = OpenSerialPort(pty.path(), 115200);
  ASSERT_TRUE(port);
  ASSERT_EQ(write(pty.device(), "new", 3), 3);
  EXPECT_EQ(ReadAll(**port, 3).front(), std::byte('n'));
}

TEST(SerialPort, SetsTheRateAndEightBitsWithoutFlowControl) {
  Pty pty;
  for (const auto& [baud, constant] : {std::pair<std::uint32_t, speed_t>{1200, B1200},
                                       {115200, B115200},
                                       {4000000, B4000000}}) {
    ASSERT_TRUE(OpenSerialPort(pty.path(), baud));
    const termios settings = pty.Settings();
    EXPECT_EQ(cfgetispeed(&settings), constant);
    EXPECT_EQ(cfgetospeed(&settings), constant);
    EXPECT_EQ(settings.c_cflag & (CSIZE | PARENB), static_cast<tcflag_t>(CS8));
    EXPECT_EQ(settings.c_iflag & (IXON | ICRNL), 0u);
    EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG), 0u);
  }
}

TEST(SerialPort, IsOpenOnceAtATime) {
  Pty pty;
  auto port = OpenSerialPort(pty.path(), 115200);
  ASSERT_TRUE(port);
  const auto second = OpenSerialPort(pty.path(), 115200);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr(pty.path()));
  EXPECT_THAT(second.error().message, HasSubstr("another process has it"));
  EXPECT_EQ((*port)->Write(EveryByte()), 256u) << "the first goes on";
  port->reset();
  EXPECT_TRUE(OpenSerialPort(pty.path(), 115200));
}

TEST(SerialPort, IsFreeAgainWhenItsProcessIsKilled) {
  Pty pty;
  std::array<int, 2> opened{};
  ASSERT_EQ(pipe(opened.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto port = OpenSerialPort(pty.path(), 115200);
    const char sent = port ? 'o' : 'x';
    if (write(opened[1], &sent, 1) == 1) pause();
    _exit(1);
  }
  char sent = 0;
  ASSERT_EQ(read(opened[0], &sent, 1), 1);
  EXPECT_EQ(sent, 'o');
  EXPECT_FALSE(OpenSerialPort(pty.path(), 115200));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(OpenSerialPort(pty.path(), 115200));
}

TEST(SerialPort, AnUnusualRateIsRefused) {
  Pty pty;
  const auto port = OpenSerialPort(pty.path(), 115201);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().code, ErrorCode::kInvalidValue);
  EXPECT_THAT(port.error().message, HasSubstr("115201"));
}

TEST(SerialPort, AnAbsentDeviceIsNamed) {
  const auto port = OpenSerialPort("/dev/ttyNoSuchLine", 115200);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().code, ErrorCode::kIo);
  EXPECT_THAT(port.error().message, HasSubstr("/dev/ttyNoSuchLine"));
  EXPECT_THAT(port.error().message, HasSubstr("No such file"));
}

TEST(SerialPort, WhatIsNoTerminalIsRefused) {
  const auto port = OpenSerialPort("/dev/null", 115200);
  ASSERT_FALSE(port);
  EXPECT_THAT(port.error().message, HasSubstr("not a terminal"));
}

TEST(SerialPort, AnUnpluggedLineIsLostForReadingAndWriting) {
  Pty pty;
  auto port = OpenSerialPort(pty.path(), 115200);
  ASSERT_TRUE(port);
  pty.Unplug();
  std::array<std::byte, 16> buffer{};
  const auto got = (*port)->Read(buffer);
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, ErrorCode::kLinkLost);
  EXPECT_THAT(got.error().message, HasSubstr(pty.path()));
  const auto taken = (*port)->Write(buffer);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().code, ErrorCode::kLinkLost);
}

}  // namespace
}  // namespace intaglio::link
