#pragma once

// The console's audit log: a line of JSON (ConsoleAudit) of each press and each log-in.
// Written in a thread of its own, and at most kMaxBytes: then the file is renamed to
// NAME.1, in place of the one before.

#include <filesystem>

#include "proto/console.pb.h"
#include "services/console/answers/work_queue.h"

namespace intaglio::console {

class AuditLog {
 public:
  static constexpr std::uintmax_t kMaxBytes = 64 << 20;
  /// An empty name: nothing is written.
  explicit AuditLog(std::filesystem::path file, std::uintmax_t max_bytes = kMaxBytes)
      : file_(std::move(file)), max_bytes_(max_bytes) {}

  /// From any thread; sets its time. A disk that fails is reported on stderr, and delays
  /// nothing.
  void Add(ConsoleAudit entry);

 private:
  void Write(const std::string& line);

  const std::filesystem::path file_;
  const std::uintmax_t max_bytes_;
  bool failed_ = false;  // in the queue's thread
  static constexpr std::size_t kMaxWaiting = 1000;
  WorkQueue queue_{kMaxWaiting};
};

}  // namespace intaglio::console
