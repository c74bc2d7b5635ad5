#pragma once

// What decides at which instant a pulse fires, within the tick that the synchronizer has
// armed. Chosen by pulse_trigger of the machine profile.
//
// Guarantees of every trigger, which the controllers keep and
// tests/services/synchronizer/pulses/pulse_trigger_test.cc checks:
//  1. No pulse in a tick that is not armed.
//  2. At most one pulse in an armed tick, and at most one for a knot.
//  3. No pulse unless the stage is within its position tolerance of the knot.
//  4. No pulse while an interlock is open, the lamp is cold or every shutter is closed.
//  5. Every armed tick has one outcome, which is reported for this tick.
//
// The objects have no state; they may be used from any thread.

#include <span>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/motion/planner.h"
#include "proto/machine.pb.h"
#include "services/platform/link/laser_protocol.h"

namespace intaglio::synchronizer {

class PulseTrigger {
 public:
  virtual ~PulseTrigger() = default;

  virtual PulseTriggerKind kind() const = 0;
  /// The name of the profile's value, e.g. "at_tick".
  virtual std::string_view name() const = 0;
  /// kUnsupported with the remedy when this laser controller cannot do it.
  virtual Status CheckLaser(const link::LaserIdentity& laser) const = 0;
  /// Puts the trigger into a window of decided ticks.
  virtual void Mark(link::ArmWindow& window) const = 0;
  /// Changes what the motion has to be like for this trigger.
  virtual void Adapt(motion::PlanOptions& plan) const = 0;
};

/// At the lamp sync of the armed tick: the motion is planned, and compensated for the
/// drive, to be at the point then.
const PulseTrigger& TriggerAtTick();

/// At the place: the stage's controller compares positions and fires the laser when it
/// passes nearest to the knot, within the armed tick. A stage that comes late by its lag
/// fires late; so the commands are those of the plan, without compensation, and only the
/// deviation across the way is left.
const PulseTrigger& TriggerAtPlace();

std::span<const PulseTrigger* const> PulseTriggers();
/// Null when this program knows no such trigger.
const PulseTrigger* FindPulseTrigger(PulseTriggerKind kind);

}  // namespace intaglio::synchronizer
