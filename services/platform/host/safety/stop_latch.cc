#include "services/platform/host/safety/stop_latch.h"

#include <algorithm>

#include "services/platform/bus/samples.h"

namespace intaglio::host {

std::vector<intaglio_StopPress> WireOf(const std::vector<StopPress>& presses) {
  std::vector<intaglio_StopPress> wire;
  wire.reserve(presses.size());
  for (const StopPress& press : presses) {
    wire.push_back({bus::Borrow(press.source), press.number});
  }
  return wire;
}

bool StopLatch::Receive(const intaglio_EmergencyStop& sample) {
  if (sample.pressed) return TakePress(bus::View(sample.source), sample.number);
  bool news = false;
  for (const intaglio_StopPress& press : bus::View(sample.released)) {
    news = TakeRelease(bus::View(press.source), press.number) || news;
  }
  return news;
}

bool StopLatch::TakeHeld(std::string_view listener,
                         std::span<const intaglio_StopPress> presses) {
  presses = presses.first(std::min(presses.size(), kMaxSources));
  const auto known = elsewhere_.find(listener);
  const bool same =
      known == elsewhere_.end()
          ? presses.empty()
          : std::equal(presses.begin(), presses.end(), known->second.begin(),
                       known->second.end(),
                       [](const intaglio_StopPress& a, const StopPress& b) {
                         return a.number == b.number && bus::View(a.source) == b.source;
                       });
  if (same) return false;
  bool news = false;
  std::vector<StopPress> held;
  held.reserve(presses.size());
  for (const intaglio_StopPress& press : presses) {
    held.push_back({std::string(bus::View(press.source)), press.number});
    news = TakePress(held.back().source, press.number) || news;
  }
  if (held.empty()) {
    elsewhere_.erase(known);
  } else {
    elsewhere_.insert_or_assign(std::string(listener), std::move(held));
  }
  UpdateHeld();
  return news;
}

bool StopLatch::TakePress(std::string_view source, std::uint64_t number) {
  number = std::max<std::uint64_t>(number, 1);
  Numbers* const numbers = Find(source);
  if (numbers == nullptr) return HoldUnnamed();
  const bool news = number > std::max(numbers->pressed, numbers->released);
  if (number <= numbers->pressed) return false;
  numbers->pressed = number;
  numbers->changed_at = ++changes_;
  UpdateHeld();
  return news;
}

bool StopLatch::TakeRelease(std::string_view source, std::uint64_t number) {
  Numbers* const numbers = Find(source);
  if (numbers == nullptr) return true;  // forgotten: its press stops when it comes
  const bool news = number > std::max(numbers->pressed, numbers->released);
  if (number <= numbers->released) return false;
  numbers->released = number;
  numbers->changed_at = ++changes_;
  UpdateHeld();
  return news;
}

StopLatch::Numbers* StopLatch::Find(std::string_view source) {
  if (const auto known = sources_.find(source); known != sources_.end())
    return &known->second;
  if (source.size() > kMaxSourceLength) return nullptr;
  if (sources_.size() == kMaxSources) {
    auto oldest = sources_.end();
    for (auto it = sources_.begin(); it != sources_.end(); ++it) {
      const bool older =
          oldest == sources_.end() || it->second.changed_at < oldest->second.changed_at;
      if (!it->second.held() && older) oldest = it;
    }
    if (oldest == sources_.end()) return nullptr;
    sources_.erase(oldest);
  }
  return &sources_[std::string(source)];
}

bool StopLatch::HoldUnnamed() {
  if (unnamed_) return false;
  unnamed_ = true;
  ++revision_;
  return true;
}

void StopLatch::UpdateHeld() {
  std::map<std::string, std::uint64_t> numbers;
  for (const auto& [source, own] : sources_) {
    if (own.held()) numbers[source] = own.pressed;
  }
  for (const auto& [listener, presses] : elsewhere_) {
    for (const StopPress& press : presses)
      numbers[press.source] = std::max(numbers[press.source], press.number);
  }
  std::vector<StopPress> held;
  held.reserve(numbers.size());
  for (const auto& [source, number] : numbers) held.push_back({source, number});
  if (held == held_) return;
  held_ = std::move(held);
  ++revision_;
}

}  // namespace intaglio::host
