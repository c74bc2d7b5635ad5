#include "services/job_service/last_seen.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <fstream>

#include "services/job_service/boot_clock.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 1s;

std::string BootId() {
  std::string id;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), id);
  return id;
}

}  // namespace

LastSeen::LastSeen(const std::filesystem::path& file)
    : file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)), boot_(BootId()) {
  std::array<char, 96> text{};
  if (file_ < 0 || pread(file_, text.data(), text.size() - 1, 0) <= 0) return;
  std::array<char, 64> boot{};
  long long at_ns = 0;
  if (std::sscanf(text.data(), "%63s %lld", boot.data(), &at_ns) != 2) return;
  const std::chrono::nanoseconds at(at_ns), now = SinceBoot();
  if (boot_.empty() || boot_ != boot.data() || at > now) return;
  absence_ = now - at;
}

LastSeen::~LastSeen() {
  if (file_ >= 0) close(file_);
}

void LastSeen::Note() {
  const auto now = SinceBoot();
  if (file_ < 0 || now < next_) return;
  next_ = now + kPeriod;
  const std::string text = fmt::format("{} {:>20}\n", boot_, now.count());
  [[maybe_unused]] const auto written = pwrite(file_, text.data(), text.size(), 0);
}

}  // namespace intaglio::job_service
