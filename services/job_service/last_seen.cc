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
// Turns of the job service come some 20 ms apart.
constexpr auto kLongTurn = kPeriod + 1s;

std::string BootId() {
  std::string id;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), id);
  return id;
}

}  // namespace

LastSeen::LastSeen(const std::filesystem::path& file)
    : file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)), boot_(BootId()) {
  std::array<char, 192> text{};
  if (file_ < 0 || pread(file_, text.data(), text.size() - 1, 0) <= 0) return;
  std::array<char, 64> boot{};
  long long at_ns = 0, since_ns = 0, sum_ns = 0;
  const int count = std::sscanf(text.data(), "%63s %lld %lld %lld", boot.data(), &at_ns,
                                &since_ns, &sum_ns);
  if (count != 2 && count != 4) return;
  const std::chrono::nanoseconds at(at_ns), now = SinceBoot();
  if (boot_.empty() || boot_ != boot.data() || at > now) return;
  // An older program wrote no sum.
  host::AbsenceSum::Kept kept;
  if (count == 4) {
    const host::AbsenceSum::Kept longest_present = kept;
    kept = {std::chrono::nanoseconds(since_ns), std::chrono::nanoseconds(sum_ns)};
    const bool sane = kept.sum.count() >= 0 && kept.sum <= now &&
                      kept.present_since <= at &&
                      kept.present_since >= longest_present.present_since;
    if (!sane) return;
  }
  sum_ = host::AbsenceSum(kept);
  sum_.Begin(at);
  absence_ = sum_.Total(now);
  sum_.End(now);
}

LastSeen::~LastSeen() {
  if (file_ >= 0) close(file_);
}

void LastSeen::Note() {
  const auto now = SinceBoot();
  if (file_ < 0 || (noted_at_.count() >= 0 && now - noted_at_ < kPeriod)) return;
  if (noted_at_.count() >= 0 && now - noted_at_ > kLongTurn) {
    sum_.Begin(noted_at_);
    sum_.End(now);
  }
  noted_at_ = now;
  const auto [since, sum] = sum_.ToKeep();
  const std::string text = fmt::format("{} {:>20} {:>20} {:>20}\n", boot_, now.count(),
                                       since.count(), sum.count());
  [[maybe_unused]] const auto written = pwrite(file_, text.data(), text.size(), 0);
}

}  // namespace intaglio::job_service
