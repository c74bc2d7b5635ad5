#pragma once

// A virtual BJJCZ board in real time that listens on a Unix-domain socket, one host at a
// time, and keeps the bytes that came.

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/services/drivers/bjjcz/bjjcz_machine.h"

namespace intaglio::drivers {

/// One without a fibre laser; it was homed, so that point_rig's z is 0.
inline bjjcz::VirtualBjjczOptions PlainBoard() {
  bjjcz::VirtualBjjczOptions options;
  options.needs_oscillator = false;
  return options;
}

class BoardAtSocket {
 public:
  BoardAtSocket(const std::string& path, bjjcz::VirtualBjjczOptions options)
      : board_(options), path_(path) {
    board_.SetAxis(51000);
    board_.SetInput(kBjjczDoorInput, true);
    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    path.copy(at.sun_path, sizeof at.sun_path - 1);
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    EXPECT_EQ(listen(listener_, 5), 0);
    thread_ = std::jthread([this](const std::stop_token& stop) { Serve(stop); });
  }
  BoardAtSocket(const BoardAtSocket&) = delete;
  BoardAtSocket& operator=(const BoardAtSocket&) = delete;
  ~BoardAtSocket() {
    Stop();
    close(listener_);
    if (host_ >= 0) close(host_);
    std::filesystem::remove(path_);
  }
  /// Then bytes and flashes are read.
  void Stop() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }
  const bjjcz::VirtualBjjcz& board() const { return board_; }
  const std::string& bytes() const { return bytes_; }

 private:
  void Serve(const std::stop_token& stop) {
    auto last = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      const int next = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      if (next >= 0) {
        if (host_ >= 0) close(host_);
        host_ = next;
        board_.Reopen();
      }
      std::array<char, 4096> buffer;
      ssize_t count = 0;
      while (host_ >= 0 && (count = read(host_, buffer.data(), buffer.size())) > 0) {
        bytes_.append(buffer.data(), static_cast<std::size_t>(count));
        board_.Write({buffer.data(), static_cast<std::size_t>(count)});
      }
      const auto now = std::chrono::steady_clock::now();
      board_.Advance(std::chrono::duration<double, std::micro>(now - last).count());
      last = now;
      const std::string sent = board_.Read();
      if (host_ >= 0 && !sent.empty())
        (void)send(host_, sent.data(), sent.size(), MSG_NOSIGNAL);
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  }

  bjjcz::VirtualBjjcz board_;
  std::string path_, bytes_;
  int listener_ = -1, host_ = -1;
  std::jthread thread_;
};

}  // namespace intaglio::drivers
