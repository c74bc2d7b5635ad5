#include "services/virtual_engraver/lines/late_line.h"

#include <algorithm>
#include <array>

#include "engrave/core/try.h"

namespace intaglio::virtual_engraver {
namespace {
// What a line holds at most; more is not taken, as by a full buffer of a serial port.
constexpr std::size_t kMaxBytes = 65536;
}  // namespace

LateLine::LateLine(std::unique_ptr<link::ByteStream> inner,
                   std::chrono::nanoseconds jitter, unsigned seed,
                   link::SteadyClock clock)
    : inner_(std::move(inner)),
      jitter_(jitter),
      random_(seed),
      clock_(std::move(clock)) {}

void LateLine::Delay(Way& way, std::span<const std::byte> bytes) {
  const auto late = std::chrono::nanoseconds(static_cast<std::int64_t>(
      random_() % static_cast<std::uint64_t>(jitter_.count() + 1)));
  way.last_due = std::max(way.last_due, clock_() + late);
  way.pieces.push_back({way.last_due, {bytes.begin(), bytes.end()}});
  way.size += bytes.size();
}

Status LateLine::TakeIn() {
  std::array<std::byte, 4096> buffer;
  while (in_.size < kMaxBytes) {
    const auto got = INTAGLIO_TRY(inner_->Read(buffer));
    if (got == 0) break;
    Delay(in_, std::span(buffer).first(got));
  }
  return {};
}

Status LateLine::LetOut() {
  const auto now = clock_();
  while (!out_.pieces.empty() && out_.pieces.front().due <= now) {
    auto& bytes = out_.pieces.front().bytes;
    const auto sent = INTAGLIO_TRY(inner_->Write(bytes));
    out_.size -= sent;
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(sent));
    if (!bytes.empty()) break;
    out_.pieces.pop_front();
  }
  return {};
}

Result<std::size_t> LateLine::Read(std::span<std::byte> buffer) {
  INTAGLIO_TRY(LetOut());
  INTAGLIO_TRY(TakeIn());
  const auto now = clock_();
  std::size_t count = 0;
  while (count < buffer.size() && !in_.pieces.empty() && in_.pieces.front().due <= now) {
    auto& bytes = in_.pieces.front().bytes;
    const std::size_t part = std::min(buffer.size() - count, bytes.size());
    const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(part);
    std::copy(bytes.begin(), end, buffer.begin() + static_cast<std::ptrdiff_t>(count));
    bytes.erase(bytes.begin(), end);
    count += part;
    in_.size -= part;
    if (bytes.empty()) in_.pieces.pop_front();
  }
  return count;
}

Result<std::size_t> LateLine::Write(std::span<const std::byte> bytes) {
  if (out_.size >= kMaxBytes) return 0;
  if (!bytes.empty()) Delay(out_, bytes);
  INTAGLIO_TRY(LetOut());
  return bytes.size();
}

}  // namespace intaglio::virtual_engraver
