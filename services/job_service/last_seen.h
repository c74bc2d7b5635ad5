#pragma once

// For how long there was no job service: a small file beside the queue, written anew
// every second. Measured by the time since the machine was switched on, which cannot be
// set by hand and goes on while it sleeps; another boot is an absence of unknown length.
// Not synced: what matters over a power failure is that the boot is another.

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

namespace intaglio::job_service {

class LastSeen {
 public:
  /// Reads what the previous job service has left.
  explicit LastSeen(const std::filesystem::path& file);
  ~LastSeen();
  LastSeen(const LastSeen&) = delete;
  LastSeen& operator=(const LastSeen&) = delete;

  /// nullopt: never seen, or not since the machine was switched on.
  std::optional<std::chrono::nanoseconds> absence() const { return absence_; }
  /// Cheap when nothing is due. A disk that refuses makes the next absence unknown.
  void Note();

 private:
  int file_;
  std::string boot_;
  std::optional<std::chrono::nanoseconds> absence_;
  std::chrono::nanoseconds next_{0};
};

}  // namespace intaglio::job_service
