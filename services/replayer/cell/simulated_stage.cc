#include "services/replayer/cell/simulated_stage.h"

#include <utility>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"

namespace intaglio::replayer {
namespace {

using namespace std::chrono_literals;

constexpr auto kStatePeriod = 20ms;
constexpr std::uint32_t kSegmentWindowBatches = 16;  // as the bridge's
constexpr std::uint64_t kSubticksPerTick = 65536;

intaglio_MotionFault FaultOf(const std::string& name) {
  constexpr std::pair<const char*, intaglio_MotionFault> kFaults[] = {
      {"MOTION_STARVED", intaglio_MOTION_STARVED},
      {"MOTION_LIMIT", intaglio_MOTION_LIMIT},
      {"MOTION_FOLLOWING_ERROR", intaglio_MOTION_FOLLOWING_ERROR},
      {"MOTION_LATE", intaglio_MOTION_LATE},
      {"MOTION_LINK_LOST", intaglio_MOTION_LINK_LOST},
      {"MOTION_SAFE_STATE", intaglio_MOTION_SAFE_STATE},
      {"MOTION_WRONG_CONTROLLER", intaglio_MOTION_WRONG_CONTROLLER},
      {"MOTION_NO_AIR", intaglio_MOTION_NO_AIR},
      {"MOTION_PLACE_LOST", intaglio_MOTION_PLACE_LOST}};
  for (const auto& [known, fault] : kFaults) {
    if (name == known) return fault;
  }
  return intaglio_MOTION_OK;
}

}  // namespace

SimulatedStage::SimulatedStage(bus::Bus& bus, std::string cell, std::string instance)
    : cell_(std::move(cell)),
      batches_(bus, bus::kMotionSegmentBatch, cell_),
      states_(bus, bus::kMotionState, cell_),
      credit_(bus, std::move(instance), bus::RolePartition(bus::CellRole(cell_))) {}

void SimulatedStage::Fail(const std::string& fault, const std::string& message) {
  fault_ = FaultOf(fault);
  message_ = message;
  at_rest_ = at_rest_ || fault_ != intaglio_MOTION_OK;
  changed_ = true;
}

void SimulatedStage::Begin(const SegmentMessages& messages) {
  EndStream();
  run_ = messages.run;
  start_tick_ = messages.start_tick;
  subticks_ = 0;
  whole_ = at_rest_ = false;
  fault_ = intaglio_MOTION_OK;
  message_.clear();
  stream_ = bus::StreamName(messages.job_uid, run_, bus::kMotionSegmentBatch.name);
  (void)credit_.Open(stream_, batches_.guid(), kSegmentWindowBatches);
}

void SimulatedStage::EndStream() {
  if (!stream_.empty()) (void)credit_.Close(stream_);
  stream_.clear();
}

bool SimulatedStage::Take(CellListener& listener) {
  bool begun = false;
  batches_.TakeAll([&](const intaglio_MotionSegmentBatch& sample,
                       const bus::SampleOrigin& origin) {
    if (!origin.alive) return;
    const SegmentMessages messages = MessageOf(sample);
    begun =
        listener.Receive(messages, static_cast<std::uint64_t>(origin.source_ns)) || begun;
    changed_ = true;
    if (messages.abort) {
      if (messages.run < run_) return;
      run_ = messages.run;
      at_rest_ = true;
      return EndStream();
    }
    if (messages.run > run_) Begin(messages);
    if (messages.run != run_ || stream_.empty()) return;
    for (const std::uint32_t subticks : messages.duration_subticks) subticks_ += subticks;
    whole_ = messages.last;
    (void)credit_.Consumed(stream_, messages.number + 1);
    if (whole_) EndStream();
  });
  return begun;
}

bool SimulatedStage::Turn(std::chrono::nanoseconds now, std::uint64_t tick,
                          CellListener& listener) {
  const bool begun = Take(listener);
  if (!at_rest_ && whole_ && tick >= start_tick_ + subticks_ / kSubticksPerTick)
    at_rest_ = changed_ = true;
  if (changed_ || now >= next_state_) {
    changed_ = false;
    next_state_ = now + kStatePeriod;
    SendReports(tick);
  }
  return begun;
}

void SimulatedStage::SendReports(std::uint64_t tick) {
  intaglio_MotionState sample{};
  sample.cell = bus::Borrow(cell_);
  sample.tick = tick;
  sample.x_mm = at_mm_.x();
  sample.y_mm = at_mm_.y();
  sample.z_mm = at_mm_.z();
  sample.run = run_;
  sample.highest_run = run_;
  sample.covered_through_tick = start_tick_ + subticks_ / kSubticksPerTick;
  sample.at_rest = at_rest_;
  sample.fault = fault_;
  sample.message = bus::Borrow(message_);
  sample.has_block_stage = block_mm_.has_value();
  sample.block_x_mm = block_mm_.value_or(Vec2::Zero()).x();
  sample.block_y_mm = block_mm_.value_or(Vec2::Zero()).y();
  (void)states_.Write(sample);
}

}  // namespace intaglio::replayer
