#pragma once

// Publishes the room on the disks of the queue and of the results, whether or not they
// can be written. Used from one thread.

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "services/platform/bus/bus.h"

namespace intaglio::job_service {

/// Bytes.
struct DiskRoom {
  std::uint64_t free = 0;  ///< that this user may write
  std::uint64_t total = 0;
};

/// The room on the disk of `folder`, or of the nearest folder above it that exists.
Result<DiskRoom> RoomOf(const std::filesystem::path& folder);

class DiskReport {
 public:
  static constexpr std::chrono::seconds kPeriod{1};

  /// `folders`: of two on one disk the first is published.
  DiskReport(bus::Bus& bus, std::string instance,
             const std::vector<std::filesystem::path>& folders);
  /// Cheap when nothing is due. `now`: any steady clock.
  void Turn(std::chrono::nanoseconds now);

 private:
  void Publish(const std::filesystem::path& folder);

  std::string instance_;
  std::vector<std::filesystem::path> folders_;
  bus::Writer<intaglio_DiskSpace> spaces_;
  std::chrono::nanoseconds next_{0};
};

}  // namespace intaglio::job_service
