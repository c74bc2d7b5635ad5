#include "services/platform/command_line/open_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>

namespace intaglio::command_line {
namespace {

/// Counts those of the descriptors below `limit`, at most kMinFreeDescriptors.
std::size_t FreeBelow(rlim_t limit) {
  std::size_t free = 0;
  for (rlim_t fd = 0; fd < limit && free < kMinFreeDescriptors; ++fd) {
    if (fcntl(static_cast<int>(fd), F_GETFD) < 0) ++free;
  }
  return free;
}

}  // namespace

Status CheckOpenFiles() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return {};
  if (FreeBelow(limit.rlim_cur) >= kMinFreeDescriptors) return {};
  // The descriptors that are open have any numbers: twice as many have enough free ones.
  limit.rlim_cur = std::min<rlim_t>(
      limit.rlim_max,
      std::max<rlim_t>(2 * kMinFreeDescriptors, limit.rlim_cur + kMinFreeDescriptors));
  (void)setrlimit(RLIMIT_NOFILE, &limit);
  (void)getrlimit(RLIMIT_NOFILE, &limit);
  const std::size_t free = FreeBelow(limit.rlim_cur);
  if (free >= kMinFreeDescriptors) return {};
  return Fail(ErrorCode::kRefused,
              fmt::format("the limit of open files is {}, and {} of these file "
                          "descriptors are free: {} are needed; raise it with `ulimit -n "
                          "1024` (of a unit of systemd: LimitNOFILE=1024)",
                          limit.rlim_cur, free, kMinFreeDescriptors));
}

}  // namespace intaglio::command_line
