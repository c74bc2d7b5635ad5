#pragma once

// Clients of one computer that join the bus a few at a time. Every participant of a
// domain makes itself known to every other one, so that the work of n clients that join
// at once grows with n * n: 50 of them on two cores kept a job service from answering for
// 90 s, one after the other they took 5 s.

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <utility>

#include "services/client/locks/file_lock.h"

namespace intaglio::client {

/// A place among the clients that are on the bus. A client that follows a job for long
/// gives it back once it is answered. Commands that stop or move a machine take none:
/// they never wait for others.
class BusTurn {
 public:
  /// A user of one computer has so many at a time.
  static constexpr std::size_t kPlaces = 4;
  /// A client goes on without a place after this time: those that have the places may
  /// have been stopped.
  static constexpr std::chrono::seconds kLongest{120};

  /// Waits for a place. Where the folder cannot be written, there is none, and no wait.
  /// `folder`: default $XDG_RUNTIME_DIR/intaglio, else /tmp/intaglio-UID.
  explicit BusTurn(const std::filesystem::path& folder = DefaultFolder(),
                   std::chrono::milliseconds longest = kLongest);
  BusTurn(BusTurn&& other) noexcept : place_(std::exchange(other.place_, {})) {}
  BusTurn& operator=(BusTurn&&) = delete;

  /// Gives the place back; the end of the process does it as well.
  void End() { place_.reset(); }
  bool has_place() const { return place_.has_value(); }

  static std::filesystem::path DefaultFolder();

 private:
  std::optional<FileLock> place_;
};

}  // namespace intaglio::client
