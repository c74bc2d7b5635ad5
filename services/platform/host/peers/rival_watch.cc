#include "services/platform/host/peers/rival_watch.h"

namespace intaglio::host {
namespace {

bool Works(intaglio_HealthState state) {
  return state != intaglio_HEALTH_STARTING && state != intaglio_HEALTH_STOPPING;
}

}  // namespace

void RivalWatch::Receive(const Rival& rival, Nanoseconds now) {
  if (rival.instance == own_instance_) return;
  Received& received = received_[rival.instance];
  received.rival = rival;
  ++received.count;
  received.last = now;
}

RivalWatch::Verdict RivalWatch::JudgeStart(Nanoseconds now) {
  bool waits = now - began_ < period_;
  for (const auto& [instance, received] : received_) {
    if (IsStale(received, now)) continue;
    const intaglio_HealthState state = received.rival.state;
    if (starting_ == Starting::kWaits && state == intaglio_HEALTH_STARTING) continue;
    if (received.count < 2 || state == intaglio_HEALTH_STOPPING) {
      waits = true;
    } else if (Works(state) || instance < own_instance_) {
      rival_ = received.rival;
      return Verdict::kEnd;
    }
  }
  return waits ? Verdict::kWait : Verdict::kGoOn;
}

RivalWatch::Verdict RivalWatch::JudgeWork(Nanoseconds now) {
  for (const auto& [instance, received] : received_) {
    if (IsStale(received, now) || received.count < 2 || !Works(received.rival.state))
      continue;
    if (instance > own_instance_) continue;
    rival_ = received.rival;
    return Verdict::kEnd;
  }
  return Verdict::kGoOn;
}

}  // namespace intaglio::host
