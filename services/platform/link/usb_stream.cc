#include "services/platform/link/usb_stream.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/link/usb_device.h"

namespace intaglio::link {
namespace {

using namespace std::chrono_literals;

// Transfers end by it, so that a stream is closed soon.
constexpr auto kUsbTurn = 20ms;
// What is left of an earlier host comes at once.
constexpr auto kUsbStale = 5ms;
constexpr std::size_t kMaxUsbTransferBytes = 4096, kMaxUsbTransfers = 8;
constexpr std::size_t kMaxUsbReceivedBytes = 64 * 1024;

class UsbStream final : public ByteStream {
 public:
  explicit UsbStream(std::unique_ptr<UsbDevice> device)
      : device_(std::move(device)),
        event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
        sender_([this](const std::stop_token& stop) { SendAll(stop); }),
        receiver_([this](const std::stop_token& stop) { ReceiveAll(stop); }) {}
  ~UsbStream() override {
    sender_.request_stop();
    receiver_.request_stop();
    sender_.join();
    receiver_.join();
    close(event_);
  }

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    const std::lock_guard lock(mutex_);
    const std::size_t count = std::min(buffer.size(), received_.size());
    const auto end = received_.begin() + static_cast<std::ptrdiff_t>(count);
    std::copy(received_.begin(), end, buffer.begin());
    received_.erase(received_.begin(), end);
    if (count == 0 && lost_) return tl::unexpected(*lost_);
    eventfd_t ignored = 0;
    if (received_.empty() && !lost_) (void)eventfd_read(event_, &ignored);
    changed_.notify_all();
    return count;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    const std::lock_guard lock(mutex_);
    if (lost_) return tl::unexpected(*lost_);
    if (!connected_ || bytes.empty() || waiting_.size() >= kMaxUsbTransfers)
      return std::size_t{0};
    const auto taken = bytes.first(std::min(bytes.size(), kMaxUsbTransferBytes));
    waiting_.emplace_back(taken.begin(), taken.end());
    changed_.notify_all();
    return taken.size();
  }
  int fd() const override { return event_; }
  bool connected() const override {
    const std::lock_guard lock(mutex_);
    return connected_;
  }

 private:
  void SendAll(const std::stop_token& stop) {
    for (;;) {
      std::vector<std::byte> next;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, stop, [this] { return !waiting_.empty() || lost_; });
        if (stop.stop_requested() || lost_) return;
        next = waiting_.front();
      }
      std::size_t sent = 0;
      while (sent < next.size() && !stop.stop_requested()) {
        const auto moved = device_->Send(std::span(next).subspan(sent), kUsbTurn);
        if (!moved) return Lose(moved.error());
        sent += *moved;
      }
      const std::lock_guard lock(mutex_);
      waiting_.pop_front();
    }
  }

  void ReceiveAll(const std::stop_token& stop) {
    std::array<std::byte, 512> buffer;
    bool is_fresh = false;
    while (!stop.stop_requested()) {
      const auto got = device_->Receive(buffer, is_fresh ? kUsbTurn : kUsbStale);
      if (!got) return Lose(got.error());
      std::unique_lock lock(mutex_);
      if (!is_fresh) {
        connected_ = is_fresh = *got == 0;
        continue;
      }
      if (*got == 0) continue;
      received_.insert(received_.end(), buffer.begin(),
                       buffer.begin() + static_cast<std::ptrdiff_t>(*got));
      (void)eventfd_write(event_, 1);
      changed_.wait(lock, stop,
                    [this] { return received_.size() < kMaxUsbReceivedBytes; });
    }
  }

  void Lose(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (!lost_) lost_ = error;
    (void)eventfd_write(event_, 1);
    changed_.notify_all();
  }

  std::unique_ptr<UsbDevice> device_;
  int event_;  ///< readable while there are bytes, or it is lost
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<std::vector<std::byte>> waiting_;  ///< transfers, the first is sent
  std::deque<std::byte> received_;
  std::optional<Error> lost_;
  bool connected_ = false;
  std::jthread sender_, receiver_;  // last: they use what is above
};

}  // namespace

Status CheckUsb(const std::string& text) {
  INTAGLIO_TRY(ParseUsbAddress(text));
  return {};
}

Result<std::unique_ptr<ByteStream>> OpenUsb(const std::string& text) {
  const UsbAddress address = INTAGLIO_TRY(ParseUsbAddress(text));
  return std::make_unique<UsbStream>(INTAGLIO_TRY(UsbDevice::Open(address)));
}

}  // namespace intaglio::link
