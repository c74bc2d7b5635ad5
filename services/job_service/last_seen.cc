#include "services/job_service/last_seen.h"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <utility>

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

struct SeenNote {
  std::string boot;
  std::chrono::nanoseconds at{0};
  host::AbsenceSum::Kept kept;

  /// To the clock of another boot, at which it was written at `then`.
  void MoveTo(std::chrono::nanoseconds then) {
    const auto earliest = host::AbsenceSum::Kept().present_since;
    const auto present_for = at - kept.present_since;
    kept.present_since = present_for > then - earliest ? earliest : then - present_for;
    at = then;
  }
};

std::optional<SeenNote> NoteOf(const std::string& text) {
  std::array<char, 64> boot{};
  long long at_ns = 0, since_ns = 0, sum_ns = 0;
  const int count = std::sscanf(text.c_str(), "%63s %lld %lld %lld", boot.data(), &at_ns,
                                &since_ns, &sum_ns);
  if (count != 2 && count != 4) return std::nullopt;
  SeenNote note{boot.data(), std::chrono::nanoseconds(at_ns), {}};
  if (count == 2) return note;  // an older program wrote no sum
  const auto longest_present = note.kept.present_since;
  note.kept = {std::chrono::nanoseconds(since_ns), std::chrono::nanoseconds(sum_ns)};
  const bool sane = note.kept.sum.count() >= 0 && note.kept.present_since <= note.at &&
                    note.kept.present_since >= longest_present;
  return sane ? std::optional(note) : std::nullopt;
}

}  // namespace

LastSeen::LastSeen(NotePlace place, const std::optional<SeenByStandby>& standby)
    : place_(std::move(place)), boot_(BootId()) {
  const std::string text = place_.read();
  auto note = NoteOf(text);
  if (!note) return;
  const std::chrono::nanoseconds now = SinceBoot();
  if (standby && standby->note == text) {
    note->MoveTo(standby->at);
  } else if (boot_.empty() || boot_ != note->boot) {
    return;
  }
  if (note->at > now || note->kept.sum > now) return;
  sum_ = host::AbsenceSum(note->kept);
  sum_.Begin(note->at);
  absence_ = sum_.Total(now);
  sum_.End(now);
}

void LastSeen::Note() {
  const auto now = SinceBoot();
  if (noted_at_.count() >= 0 && now - noted_at_ < kPeriod) return;
  if (noted_at_.count() >= 0 && now - noted_at_ > kLongTurn) {
    sum_.Begin(noted_at_);
    sum_.End(now);
  }
  noted_at_ = now;
  const auto [since, sum] = sum_.ToKeep();
  place_.write(fmt::format("{} {:>20} {:>20} {:>20}\n", boot_, now.count(), since.count(),
                           sum.count()));
}

}  // namespace intaglio::job_service
