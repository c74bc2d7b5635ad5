#include "services/platform/host/peers/machine_facts.h"

#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {

using bus::View;

// Interlock and MachineFacts have these fields alike, and likewise the others below.
template <typename Sample>
void UpdateInterlock(MachineFacts& facts, const Sample& sample) {
  facts.has_interlock = true;
  facts.laser_line_up = sample.laser_link_up;
  facts.key_on = sample.key_on;
  facts.door_closed = sample.door_closed;
  facts.door_locked = sample.door_locked;
  facts.stop_released = sample.emergency_stop_released;
  facts.lamp_on = sample.lamp_on;
  facts.lamp_warm = sample.lamp_warm;
  facts.safe_state = sample.safe_state;
  facts.shutters_open = sample.shutters_open;
  facts.stop_pressed = sample.bus_stop_pressed;
  facts.open_input = View(sample.open_input);
  facts.outputs_on = View(sample.outputs_on);
  facts.stops_held.clear();
  for (const intaglio_StopPress& press : View(sample.bus_stops))
    facts.stops_held.push_back({std::string(View(press.source)), press.number});
}

template <typename Sample>
void UpdateLamp(MachineFacts& facts, const Sample& sample) {
  facts.has_lamp = true;
  facts.warm_ratio = sample.warm_ratio;
  facts.rate_hz = sample.rate_hz;
}

template <typename Sample>
void UpdateMotion(MachineFacts& facts, const Sample& sample, intaglio_MotionFault fault,
                  const char* message) {
  facts.has_motion = true;
  facts.motion_fault = fault;
  facts.motion_message = View(message);
  facts.has_block_stage = sample.has_block_stage;
  facts.block_x_mm = sample.block_x_mm;
  facts.block_y_mm = sample.block_y_mm;
}

}  // namespace

void Update(MachineFacts& facts, const intaglio_Interlock& sample) {
  UpdateInterlock(facts, sample);
}

void Update(MachineFacts& facts, const intaglio_LampSync& sample) {
  UpdateLamp(facts, sample);
}

void Update(MachineFacts& facts, const intaglio_MotionState& sample) {
  UpdateMotion(facts, sample, sample.fault, sample.message);
}

void Update(MachineFacts& facts, const intaglio_MachineFacts& sample) {
  if (sample.has_interlock) UpdateInterlock(facts, sample);
  if (sample.has_lamp) UpdateLamp(facts, sample);
  if (sample.has_motion)
    UpdateMotion(facts, sample, sample.motion_fault, sample.motion_message);
}

void Update(MachineFacts& facts, const MachineFacts& other) {
  Update(facts, WireFacts(other).sample());
}

WireFacts::WireFacts(const MachineFacts& facts)
    : facts_(facts), stops_(WireOf(facts_.stops_held)) {
  sample_.has_interlock = facts_.has_interlock;
  sample_.laser_link_up = facts_.laser_line_up;
  sample_.key_on = facts_.key_on;
  sample_.door_closed = facts_.door_closed;
  sample_.door_locked = facts_.door_locked;
  sample_.emergency_stop_released = facts_.stop_released;
  sample_.lamp_on = facts_.lamp_on;
  sample_.lamp_warm = facts_.lamp_warm;
  sample_.safe_state = facts_.safe_state;
  sample_.shutters_open = facts_.shutters_open;
  sample_.bus_stop_pressed = facts_.stop_pressed;
  bus::Borrow(sample_.bus_stops, stops_);
  sample_.open_input = bus::Borrow(facts_.open_input);
  sample_.outputs_on = bus::Borrow(facts_.outputs_on);
  sample_.has_lamp = facts_.has_lamp;
  sample_.warm_ratio = facts_.warm_ratio;
  sample_.rate_hz = facts_.rate_hz;
  sample_.has_motion = facts_.has_motion;
  sample_.motion_fault = facts_.motion_fault;
  sample_.motion_message = bus::Borrow(facts_.motion_message);
  sample_.has_block_stage = facts_.has_block_stage;
  sample_.block_x_mm = facts_.block_x_mm;
  sample_.block_y_mm = facts_.block_y_mm;
}

}  // namespace intaglio::host
