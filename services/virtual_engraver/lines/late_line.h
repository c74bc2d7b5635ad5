#pragma once

// A line that takes its time: what goes through arrives late by 0..jitter, at random, and
// in the order it was sent, both ways. Real time.

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <random>
#include <vector>

#include "services/platform/link/reliable_link.h"

namespace intaglio::virtual_engraver {

class LateLine final : public link::ByteStream {
 public:
  LateLine(std::unique_ptr<link::ByteStream> inner, std::chrono::nanoseconds jitter,
           unsigned seed, link::SteadyClock clock);

  /// Moves what is due both ways.
  Result<std::size_t> Read(std::span<std::byte> buffer) override;
  Result<std::size_t> Write(std::span<const std::byte> bytes) override;
  int fd() const override { return inner_->fd(); }

 private:
  struct Piece {
    std::chrono::nanoseconds due{0};
    std::vector<std::byte> bytes;
  };
  struct Way {
    std::deque<Piece> pieces;
    std::chrono::nanoseconds last_due{0};
    std::size_t size = 0;
  };
  void Delay(Way& way, std::span<const std::byte> bytes);
  Status TakeIn();
  Status LetOut();

  std::unique_ptr<link::ByteStream> inner_;
  std::chrono::nanoseconds jitter_;
  std::mt19937_64 random_;
  link::SteadyClock clock_;
  Way in_, out_;
};

}  // namespace intaglio::virtual_engraver
