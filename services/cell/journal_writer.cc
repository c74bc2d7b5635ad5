#include "services/cell/journal_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "engrave/core/check.h"

namespace intaglio::cell {
namespace {

constexpr std::chrono::milliseconds kTryAgain{500};

bool WriteAll(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

bool SyncFolderOf(const std::filesystem::path& file) {
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  const int handle = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return false;
  // A file system that cannot sync a folder keeps its names without.
  const bool synced = fsync(handle) == 0 || errno == EINVAL;
  close(handle);
  return synced;
}

std::string DiskError(const std::filesystem::path& path, int error_number) {
  return fmt::format(
      "cannot write the journal {}: {}; free space on the disk or choose another result "
      "directory",
      path.string(), std::strerror(error_number));
}

tl::unexpected<Error> GiveUp(int handle, const std::filesystem::path& file) {
  const int error_number = errno;
  close(handle);
  return Fail(ErrorCode::kIo, DiskError(file, error_number), file.string());
}

}  // namespace

Result<std::unique_ptr<JournalWriter>> JournalWriter::Create(
    const std::filesystem::path& file, const formats::JournalHeader& header) {
  const int handle = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (handle < 0) return Fail(ErrorCode::kIo, DiskError(file, errno), file.string());
  const auto head = formats::EncodeJournalHeader(header);
  if (!WriteAll(handle, head) || fdatasync(handle) != 0 || !SyncFolderOf(file)) {
    return GiveUp(handle, file);
  }
  return Take(handle, file);
}

Result<std::unique_ptr<JournalWriter>> JournalWriter::Continue(
    const std::filesystem::path& file) {
  const int handle = open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (handle < 0) return Fail(ErrorCode::kIo, DiskError(file, errno), file.string());
  const off_t end = lseek(handle, 0, SEEK_END);
  if (end < 0) return GiveUp(handle, file);
  const auto records = (end - static_cast<off_t>(formats::kJournalHeaderSize)) /
                       static_cast<off_t>(formats::kJournalRecordSize);
  const off_t whole = static_cast<off_t>(formats::kJournalHeaderSize) +
                      records * static_cast<off_t>(formats::kJournalRecordSize);
  if (ftruncate(handle, whole) != 0 || lseek(handle, whole, SEEK_SET) != whole ||
      fdatasync(handle) != 0) {
    return GiveUp(handle, file);
  }
  return Take(handle, file);
}

Result<std::unique_ptr<JournalWriter>> JournalWriter::Take(int handle,
                                                           std::filesystem::path file) {
  const int event = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  Require(event >= 0, "eventfd failed with errno {}", errno);
  return std::unique_ptr<JournalWriter>(
      new JournalWriter(handle, event, std::move(file)));
}

JournalWriter::JournalWriter(int file, int event, std::filesystem::path path)
    : ring_(kRingSize),
      file_(file),
      event_fd_(event),
      path_(std::move(path)),
      end_(lseek(file, 0, SEEK_CUR)) {}

void JournalWriter::Flush() {
  if (!thread_.joinable()) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  work_.release();
}

JournalWriter::~JournalWriter() {
  Flush();
  thread_.request_stop();
  work_.release();
  thread_.join();
  close(file_);
  close(event_fd_);
}

bool JournalWriter::Append(const formats::JournalRecord& record) {
  const std::uint64_t head = head_.load(std::memory_order_relaxed);
  if (head - durable() >= kRingSize) return false;
  ring_[head % kRingSize] = record;
  head_.store(head + 1, std::memory_order_release);
  return true;
}

void JournalWriter::ClearEvent() {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto got = read(event_fd_, &count, sizeof count);
}

std::string JournalWriter::error() const {
  return DiskError(path_, failed_.load(std::memory_order_acquire));
}

void JournalWriter::Run(const std::stop_token& stop) {
  for (;;) {
    if (!failed()) {
      work_.acquire();
    } else if (!stop.stop_requested()) {
      (void)work_.try_acquire_for(kTryAgain);
    }
    const bool last_round = stop.stop_requested();
    const std::uint64_t from = durable_.load(std::memory_order_relaxed);
    const std::uint64_t to = head_.load(std::memory_order_acquire);
    if (from != to) {
      failed_.store(WriteOut(from, to) ? 0 : errno, std::memory_order_release);
      const std::uint64_t one = 1;
      [[maybe_unused]] const auto signalled = write(event_fd_, &one, sizeof one);
    }
    if (last_round) return;
  }
}

bool JournalWriter::WriteOut(std::uint64_t from, std::uint64_t to) {
  block_.clear();
  for (std::uint64_t i = from; i < to; ++i) {
    const auto bytes = formats::EncodeJournalRecord(ring_[i % kRingSize]);
    block_.insert(block_.end(), bytes.begin(), bytes.end());
  }
  // Behind a part of a block that had no room.
  if (failed() && (ftruncate(file_, end_) != 0 || lseek(file_, end_, SEEK_SET) != end_))
    return false;
  if (!WriteAll(file_, block_) || fdatasync(file_) != 0) return false;
  end_ += static_cast<std::int64_t>(block_.size());
  durable_.store(to, std::memory_order_release);
  return true;
}

}  // namespace intaglio::cell
