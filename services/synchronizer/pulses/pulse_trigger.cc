#include "services/synchronizer/pulses/pulse_trigger.h"

namespace intaglio::synchronizer {
namespace {

class AtTick final : public PulseTrigger {
 public:
  PulseTriggerKind kind() const override { return PULSE_TRIGGER_AT_TICK; }
  std::string_view name() const override { return "at_tick"; }
  Status CheckLaser(const link::LaserIdentity&) const override { return {}; }
  void Mark(link::ArmWindow& window) const override { window.at_place = false; }
  void Adapt(motion::PlanOptions&) const override {}
};

class AtPlace final : public PulseTrigger {
 public:
  PulseTriggerKind kind() const override { return PULSE_TRIGGER_AT_PLACE; }
  std::string_view name() const override { return "at_place"; }
  Status CheckLaser(const link::LaserIdentity& laser) const override {
    if (laser.fires_at_place) return {};
    return Fail(ErrorCode::kUnsupported,
                "the laser controller cannot fire at a place: set pulse_trigger in the "
                "machine profile to PULSE_TRIGGER_AT_TICK");
  }
  void Mark(link::ArmWindow& window) const override {
    window.gated = window.at_place = true;
  }
  void Adapt(motion::PlanOptions& plan) const override { plan.drives = {}; }
};

}  // namespace

const PulseTrigger& TriggerAtTick() {
  static const AtTick trigger;
  return trigger;
}

const PulseTrigger& TriggerAtPlace() {
  static const AtPlace trigger;
  return trigger;
}

std::span<const PulseTrigger* const> PulseTriggers() {
  static const PulseTrigger* const triggers[] = {&TriggerAtTick(), &TriggerAtPlace()};
  return triggers;
}

const PulseTrigger* FindPulseTrigger(PulseTriggerKind kind) {
  for (const PulseTrigger* trigger : PulseTriggers()) {
    if (trigger->kind() == kind) return trigger;
  }
  return nullptr;
}

}  // namespace intaglio::synchronizer
