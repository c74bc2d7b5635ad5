#include "services/history/write_ahead_log.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <thread>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"

namespace intaglio::history {
namespace {

constexpr std::uint64_t kMaxLogBytes = 1u << 30;
constexpr std::size_t kHeaderBytes = 32, kFrameHeaderBytes = 24;
constexpr std::uint32_t kMagicLittle = 0x377f0682, kMagicBig = 0x377f0683;

using Bytes = std::span<const unsigned char>;

std::uint32_t BigAt(Bytes bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 |
         std::uint32_t{bytes[at + 2]} << 8 | std::uint32_t{bytes[at + 3]};
}

std::uint32_t LittleAt(Bytes bytes, std::size_t at) {
  return std::uint32_t{bytes[at + 3]} << 24 | std::uint32_t{bytes[at + 2]} << 16 |
         std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at]};
}

/// The running checksum of a log (chapter 4.2).
struct Checksum {
  bool big = false;
  std::uint32_t first = 0, second = 0;

  void Add(Bytes bytes) {
    for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      first += (big ? BigAt(bytes, at) : LittleAt(bytes, at)) + second;
      second += (big ? BigAt(bytes, at + 4) : LittleAt(bytes, at + 4)) + first;
    }
  }
  bool IsAt(Bytes bytes, std::size_t at) const {
    return BigAt(bytes, at) == first && BigAt(bytes, at + 4) == second;
  }
};

Status Damaged(const std::string& file, const std::string& where) {
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("the write-ahead log {} is damaged ({}): jobs that were stored "
                  "would be missing; put an intact copy of it and of the database "
                  "there, or the newest backup (intaglio restore BACKUP --replace), or "
                  "move the log away to go on without what it had",
                  file, where),
      file);
}

Status CheckLog(Bytes log, const std::string& file) {
  const std::uint32_t magic = BigAt(log, 0);
  Checksum sum{.big = magic == kMagicBig};
  sum.Add(log.first(kFrameHeaderBytes));
  const std::uint32_t page_bytes = BigAt(log, 8);
  const bool known = magic == kMagicLittle || magic == kMagicBig;
  if (!known || page_bytes < 512 || !sum.IsAt(log, kFrameHeaderBytes))
    return Damaged(file, "its header");
  std::size_t intact = 0, commits_behind = 0;
  bool is_intact = true;
  const std::size_t frame_bytes = kFrameHeaderBytes + page_bytes;
  for (std::size_t at = kHeaderBytes; at + frame_bytes <= log.size(); at += frame_bytes) {
    const Bytes frame = log.subspan(at, frame_bytes);
    // Frames of an earlier round of the log have other salts.
    const bool is_new =
        BigAt(frame, 8) == BigAt(log, 16) && BigAt(frame, 12) == BigAt(log, 20);
    if (is_intact) {
      sum.Add(frame.first(8));
      sum.Add(frame.subspan(kFrameHeaderBytes));
      is_intact = is_new && sum.IsAt(frame, 16);
      if (is_intact) ++intact;
    }
    const bool commits = is_new && BigAt(frame, 4) != 0;
    if (!is_intact && commits) ++commits_behind;
  }
  // The commit of the torn change itself may be written before its other frames.
  if (commits_behind <= 1) return {};
  return Damaged(file, fmt::format("behind page {} of it", intact));
}

}  // namespace

Status CheckWriteAheadLog(const std::filesystem::path& database) {
  const std::string file = database.string() + "-wal";
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error || size < kHeaderBytes) return {};
  const auto log = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxLogBytes));
  return CheckLog({reinterpret_cast<const unsigned char*>(log.data()), log.size()}, file);
}

Status CheckLogInUse(const std::filesystem::path& database) {
  constexpr int kReadings = 4;
  // A job service writes in shorter times than this.
  constexpr std::chrono::milliseconds kBetween{30};
  Status intact = CheckWriteAheadLog(database);
  for (int i = 1; i < kReadings && !intact; ++i) {
    std::this_thread::sleep_for(kBetween);
    intact = CheckWriteAheadLog(database);
  }
  return intact;
}

}  // namespace intaglio::history
