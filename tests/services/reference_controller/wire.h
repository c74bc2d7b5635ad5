#pragma once

// A pseudo-terminal as a wire that a test cuts, on the test's clock.

#include <poll.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "services/platform/link/byte_stream.h"

namespace intaglio::reference_controller {

/// One way of the wire. The kernel carries its bytes in its own time, the test's clock
/// stops for them: a reader waits for all that was written.
struct Way {
  bool cut = false;
  std::uint64_t cut_after = UINT64_MAX;
  std::uint64_t written = 0, read = 0, taken = 0;

  void Forget() { written = read = 0; }
};

class WireEnd final : public link::ByteStream {
 public:
  WireEnd(std::unique_ptr<link::ByteStream> inner, Way& in, Way& out,
          std::shared_ptr<void> owner)
      : inner_(std::move(inner)), in_(in), out_(out), owner_(std::move(owner)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    if (in_.read < in_.written) {
      constexpr int kPatienceMs = 2000;
      pollfd readable{inner_->fd(), POLLIN, 0};
      (void)poll(&readable, 1, kPatienceMs);
    }
    auto got = inner_->Read(buffer);
    if (got) in_.read += *got;
    return got;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    if (!out_.cut && out_.taken + bytes.size() > out_.cut_after) {
      const auto left = static_cast<std::size_t>(out_.cut_after - out_.taken);
      (void)Pass(bytes.first(left));
      out_.cut = true;
    }
    return out_.cut ? bytes.size() : Pass(bytes);
  }
  int fd() const override { return inner_->fd(); }

 private:
  Result<std::size_t> Pass(std::span<const std::byte> bytes) {
    auto sent = inner_->Write(bytes);
    if (sent) out_.written += *sent, out_.taken += *sent;
    return sent;
  }

  std::unique_ptr<link::ByteStream> inner_;
  Way &in_, &out_;
  std::shared_ptr<void> owner_;
};

/// Both ways.
struct Wire {
  Way to_controller, to_host;

  /// A new plug: nothing of the time before is in it.
  void Renew() {
    to_controller.Forget();
    to_host.Forget();
  }
  void Cut(bool cut) {
    for (Way* way : {&to_controller, &to_host}) {
      way->cut = cut;
      way->cut_after = UINT64_MAX;
    }
  }
  /// After so many bytes more to the controller nothing passes, either way.
  void CutAfter(std::uint64_t bytes) {
    to_controller.cut_after = to_controller.taken + bytes;
  }
  /// A cut is of both ways.
  void CutBothWays() {
    if (to_controller.cut) to_host.cut = true;
  }
};

}  // namespace intaglio::reference_controller
