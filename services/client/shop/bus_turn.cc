#include "services/client/shop/bus_turn.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kRetry{20};

enum class Lock { kTaken, kBusy, kImpossible };

Lock TryLock(const fs::path& file, int& fd) {
  const int opened = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (opened < 0) return Lock::kImpossible;
  if (flock(opened, LOCK_EX | LOCK_NB) == 0) {
    fd = opened;
    return Lock::kTaken;
  }
  close(opened);
  return Lock::kBusy;
}

}  // namespace

BusTurn::BusTurn(const fs::path& folder, std::chrono::milliseconds longest) {
  std::error_code error;
  if (fs::create_directories(folder, error))
    fs::permissions(folder, fs::perms::owner_all, error);
  // Clients begin at different places, so that the first finds one at its first try.
  const auto first = static_cast<std::size_t>(getpid());
  const auto end = std::chrono::steady_clock::now() + longest;
  for (;;) {
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const auto file = folder / fmt::format("client.{}", (first + i) % kPlaces);
      if (TryLock(file, fd_) != Lock::kBusy) return;
    }
    if (std::chrono::steady_clock::now() >= end) return;
    std::this_thread::sleep_for(kRetry);
  }
}

void BusTurn::End() {
  if (fd_ >= 0) close(std::exchange(fd_, -1));
}

fs::path BusTurn::DefaultFolder() {
  if (const char* user = std::getenv("XDG_RUNTIME_DIR"); user != nullptr && *user != 0)
    return fs::path(user) / "intaglio";
  return fmt::format("/tmp/intaglio-{}", geteuid());
}

}  // namespace intaglio::client
