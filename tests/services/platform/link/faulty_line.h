#pragma once

// One direction of a serial line in memory, and a stream on its ends, that corrupt bytes
// as configured: by a seeded generator, on a clock that the test moves.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <random>
#include <utility>

#include "services/platform/link/reliable_link.h"

namespace intaglio::link {

struct FaultyPipe {
  struct InFlight {
    std::chrono::nanoseconds due;
    std::byte byte;
  };
  std::deque<InFlight> bytes;
  double drop_ratio = 0, damage_ratio = 0, double_ratio = 0;  ///< of the bytes, 0..1
  std::chrono::nanoseconds delay{0};
  std::chrono::nanoseconds jitter{0};    ///< more delay at random; bytes keep their order
  double bytes_per_s = 0;                ///< 0: without limit
  std::size_t buffer_size = 4096;        ///< taken and not sent yet, as a kernel does
  bool cut = false;                      ///< bytes go in and nowhere
  std::uint64_t cut_after = UINT64_MAX;  ///< so it is from the byte of this number on
  bool stuck = false;                    ///< takes no byte
  bool gone = false;                     ///< both ends fail
  std::uint64_t taken_count = 0;
  std::chrono::nanoseconds busy_until{0}, newest_due{0};
};

class FaultyEnd : public ByteStream {
 public:
  FaultyEnd(std::shared_ptr<FaultyPipe> in, std::shared_ptr<FaultyPipe> out,
            std::shared_ptr<std::mt19937_64> random, SteadyClock clock)
      : in_(std::move(in)),
        out_(std::move(out)),
        random_(std::move(random)),
        clock_(std::move(clock)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    if (in_->gone) return Fail(ErrorCode::kLinkLost, "the test's line is gone");
    // In odd pieces, so that frames lie across them.
    const std::size_t largest = std::min<std::size_t>(buffer.size(), 97);
    std::size_t count = 0;
    while (count < largest && !in_->bytes.empty() && in_->bytes.front().due <= clock_()) {
      buffer[count++] = in_->bytes.front().byte;
      in_->bytes.pop_front();
    }
    return count;
  }

  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    if (out_->gone) return Fail(ErrorCode::kLinkLost, "the test's line is gone");
    const std::size_t count = std::min(bytes.size(), Room());
    for (std::byte byte : bytes.first(count)) {
      const auto due = Due();
      if (++out_->taken_count > out_->cut_after) out_->cut = true;
      if (out_->cut || Happens(out_->drop_ratio)) continue;
      if (Happens(out_->damage_ratio)) byte ^= std::byte((*random_)() | 1);
      out_->bytes.push_back({due, byte});
      if (Happens(out_->double_ratio)) out_->bytes.push_back({due, byte});
    }
    return count;
  }

  int fd() const override { return -1; }

 private:
  bool Happens(double ratio) {
    return ratio > 0 && std::uniform_real_distribution<double>(0, 1)(*random_) < ratio;
  }

  std::size_t Room() const {
    if (out_->stuck) return 0;
    if (out_->bytes_per_s == 0) return SIZE_MAX;
    const double wait_s =
        std::chrono::duration<double>(out_->busy_until - clock_()).count();
    const auto waiting =
        static_cast<std::size_t>(std::max(0.0, wait_s) * out_->bytes_per_s);
    return out_->buffer_size - std::min(out_->buffer_size, waiting);
  }

  std::chrono::nanoseconds Due() {
    using std::chrono::nanoseconds;
    nanoseconds due = clock_();
    if (out_->bytes_per_s > 0) {
      out_->busy_until = std::max(out_->busy_until, due) +
                         nanoseconds(static_cast<std::int64_t>(1e9 / out_->bytes_per_s));
      due = out_->busy_until;
    }
    due += out_->delay;
    if (out_->jitter.count() > 0) {
      due += nanoseconds(static_cast<std::int64_t>(
          (*random_)() % static_cast<std::uint64_t>(out_->jitter.count())));
    }
    return out_->newest_due = std::max(out_->newest_due, due);
  }

  std::shared_ptr<FaultyPipe> in_, out_;
  std::shared_ptr<std::mt19937_64> random_;
  SteadyClock clock_;
};

}  // namespace intaglio::link
