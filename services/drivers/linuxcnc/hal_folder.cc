#include "services/drivers/linuxcnc/hal_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "engrave/io/whole_file.h"

namespace intaglio::drivers {
namespace {

// The lock is inherited by all processes of the HAL, and ends with the last of them.
bool IsHeld(const std::filesystem::path& lock) {
  const int file = open(lock.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool held = flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(file);
  return held;
}

}  // namespace

Result<HalIdentity> ReadHalIdentity(const std::filesystem::path& folder,
                                    std::string_view line) {
  if (IsHeld(folder / "lock")) {
    if (const auto text = io::ReadWholeFile(folder / "identity", 4096))
      return ParseIdentity(*text);
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("no HAL runs in {}: start it with deploy/linuxcnc/start, and "
                          "name its folder in {}.device",
                          folder.string(), line));
}

}  // namespace intaglio::drivers
