#include "services/job_service/published/disk_report.h"

#include <sys/stat.h>

#include <set>
#include <utility>

#include "services/platform/bus/samples.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;

fs::path ThereOrAbove(fs::path folder) {
  std::error_code ignored;
  folder = fs::absolute(folder, ignored);
  while (!fs::exists(folder, ignored) && folder.has_relative_path())
    folder = folder.parent_path();
  return folder;
}

}  // namespace

Result<DiskRoom> RoomOf(const fs::path& folder) {
  std::error_code error;
  const fs::space_info space = fs::space(ThereOrAbove(folder), error);
  if (error) {
    return Fail(ErrorCode::kIo,
                "the disk of " + folder.string() + ": " + error.message());
  }
  return DiskRoom{space.available, space.capacity};
}

DiskReport::DiskReport(bus::Bus& bus, std::string instance,
                       const std::vector<fs::path>& folders)
    : instance_(std::move(instance)), spaces_(bus, bus::kDiskSpace) {
  std::set<dev_t> disks;
  for (const fs::path& folder : folders) {
    struct stat status = {};
    const bool known = stat(ThereOrAbove(folder).c_str(), &status) == 0;
    if (!known || disks.insert(status.st_dev).second)
      folders_.push_back(fs::absolute(folder));
  }
}

void DiskReport::Turn(std::chrono::nanoseconds now) {
  if (now < next_) return;
  next_ = now + kPeriod;
  for (const fs::path& folder : folders_) Publish(folder);
}

void DiskReport::Publish(const fs::path& folder) {
  const auto room = RoomOf(folder);
  if (!room) return;
  const std::string name = folder.string();
  intaglio_DiskSpace sample{};
  sample.instance = bus::Borrow(instance_);
  sample.folder = bus::Borrow(name);
  sample.free_bytes = room->free;
  sample.total_bytes = room->total;
  (void)spaces_.Write(sample);
}

}  // namespace intaglio::job_service
