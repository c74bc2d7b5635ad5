#include "services/client/shop/bus_turn.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kRetry{20};

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
      auto lock = FileLock::TryLock(file);
      if (lock) place_.emplace(std::move(*lock));
      if (lock || lock.error().code != ErrorCode::kRefused) return;
    }
    if (std::chrono::steady_clock::now() >= end) return;
    std::this_thread::sleep_for(kRetry);
  }
}

fs::path BusTurn::DefaultFolder() {
  if (const char* user = std::getenv("XDG_RUNTIME_DIR"); user != nullptr && *user != 0)
    return fs::path(user) / "intaglio";
  return fmt::format("/tmp/intaglio-{}", geteuid());
}

}  // namespace intaglio::client
