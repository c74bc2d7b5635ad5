#include "services/client/teach/jog_relay.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <random>

#include "services/platform/bus/samples.h"

namespace intaglio::client {
namespace {

/// An outline needs what a sample of a page does not have.
bool IsPassedOn(intaglio_ManualCommandKind kind) {
  return kind != intaglio_MANUAL_OUTLINE;
}

}  // namespace

JogRelay::JogRelay(bus::Bus& bus)
    : bus_(bus),
      process_(fmt::format("console-{}-{:08x}", getpid(), std::random_device{}())),
      states_(bus, bus::kManualState) {}

std::string JogRelay::SenderOf(std::uint64_t person) const {
  return fmt::format("{}-{}", process_, person);
}

Status JogRelay::Pass(const SentOrder& sent) {
  if (!IsPassedOn(sent.order.kind))
    return Fail(ErrorCode::kInvalidValue, "outlines are not passed on");
  if (!sent.order.place.allFinite() || !sent.order.place_max.allFinite() ||
      !std::isfinite(sent.order.speed_mm_s))
    return Fail(ErrorCode::kInvalidValue, "the place or the speed is no number");
  const std::lock_guard lock(mutex_);
  const auto known = commands_.find(sent.cell);
  if (known == commands_.end()) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("{}: no such machine answers here", sent.cell), sent.cell);
  }
  if (!known->second) {
    try {
      known->second = std::make_unique<bus::Writer<intaglio_ManualCommand>>(
          bus_, bus::kManualCommand, sent.cell);
    } catch (const bus::NotAllowedError& error) {
      return Fail(ErrorCode::kRefused, error.what());
    }
  }
  return known->second->Write(SampleOf(sent));
}

std::vector<MachineView> JogRelay::TakeNew() {
  std::map<std::string, MachineView> views;
  states_.Take([&](const intaglio_ManualState& sample) {
    MachineView& view = views[std::string(bus::View(sample.cell))];
    view.cell = bus::View(sample.cell);
    TakeState(sample, view);
  });
  std::vector<MachineView> taken;
  const std::lock_guard lock(mutex_);
  for (auto& [cell, view] : views) {
    commands_.try_emplace(cell);
    taken.push_back(std::move(view));
  }
  return taken;
}

}  // namespace intaglio::client
