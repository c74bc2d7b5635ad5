#pragma once

// Puts journal records on disk from a thread of its own, so that the tick path does no
// I/O: records go through a ring, and the tick path fires nothing whose intent is not
// durable yet.
//
//   tick path: Append(intent) ... number = appended()   ring   writer: write, fdatasync
//              fires once durable() >= number          <------ durable() = number
//
// What a full disk refuses stays in the ring and is tried again twice a second, from the
// end of the last whole block on: once there is room nothing is missing.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <semaphore>
#include <string>
#include <thread>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/formats/journal_file.h"

namespace intaglio::cell {

class JournalWriter {
 public:
  /// Creates the file (which must not exist: a journal is never written over) with its
  /// header, and its name in the folder, on disk.
  static Result<std::unique_ptr<JournalWriter>> Create(
      const std::filesystem::path& file, const formats::JournalHeader& header);
  /// Goes on behind the last whole record of a journal that is there; a torn one is cut.
  static Result<std::unique_ptr<JournalWriter>> Continue(
      const std::filesystem::path& file);
  ~JournalWriter();

  /// From one thread; neither allocates, locks nor waits. False: the ring is full.
  bool Append(const formats::JournalRecord& record);
  /// Lets the writer know that there is something to write. Its thread is started by the
  /// first call, and so has the scheduling of the thread that appends, not of the one
  /// that opened the file.
  void Flush();

  /// Records appended, and how many of them are on disk.
  std::uint64_t appended() const { return head_.load(std::memory_order_relaxed); }
  std::uint64_t durable() const { return durable_.load(std::memory_order_acquire); }
  /// The disk refuses what is to be written, as yet.
  bool failed() const { return failed_.load(std::memory_order_acquire) != 0; }
  /// The error of the disk meanwhile, and the remedy.
  std::string error() const;
  /// Readable when durable() has grown since the last ClearEvent.
  int event_fd() const { return event_fd_; }
  void ClearEvent();

 private:
  static Result<std::unique_ptr<JournalWriter>> Take(int handle,
                                                     std::filesystem::path file);
  JournalWriter(int file, int event, std::filesystem::path path);
  void Run(const std::stop_token& stop);
  bool WriteOut(std::uint64_t from, std::uint64_t to);

  static constexpr std::uint64_t kRingSize = 1u << 16;  ///< a power of two
  std::vector<formats::JournalRecord> ring_;
  std::vector<std::byte> block_;
  std::atomic<std::uint64_t> head_{0};
  std::atomic<std::uint64_t> durable_{0};
  std::atomic<int> failed_{0};  ///< errno
  std::counting_semaphore<> work_{0};
  int file_;
  int event_fd_;
  std::filesystem::path path_;
  std::int64_t end_ = 0;  ///< of the last whole block in the file
  std::jthread thread_;
};

}  // namespace intaglio::cell
