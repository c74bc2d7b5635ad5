#include "services/platform/host/peers/rival_watch.h"

namespace intaglio::host {
namespace {

bool Works(intaglio_HealthState state) {
  return state != intaglio_HEALTH_STARTING && state != intaglio_HEALTH_STOPPING;
}

}  // namespace

void RivalWatch::Hear(const Rival& rival, Nanoseconds now) {
  if (rival.instance == own_instance_) return;
  Heard& heard = heard_[rival.instance];
  heard.rival = rival;
  ++heard.count;
  heard.last = now;
}

RivalWatch::Verdict RivalWatch::JudgeStart(Nanoseconds now) {
  bool waits = now - began_ < look_;
  for (const auto& [instance, heard] : heard_) {
    if (IsStale(heard, now)) continue;
    const intaglio_HealthState state = heard.rival.state;
    if (heard.count < 2 || state == intaglio_HEALTH_STOPPING) {
      waits = true;
    } else if (Works(state) || instance < own_instance_) {
      rival_ = heard.rival;
      return Verdict::kEnd;
    }
  }
  return waits ? Verdict::kWait : Verdict::kGoOn;
}

RivalWatch::Verdict RivalWatch::JudgeWork(Nanoseconds now) {
  for (const auto& [instance, heard] : heard_) {
    if (IsStale(heard, now) || heard.count < 2 || !Works(heard.rival.state)) continue;
    if (instance > own_instance_) continue;
    rival_ = heard.rival;
    return Verdict::kEnd;
  }
  return Verdict::kGoOn;
}

}  // namespace intaglio::host
