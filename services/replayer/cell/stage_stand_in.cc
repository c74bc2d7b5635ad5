#include "services/replayer/cell/stage_stand_in.h"

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
      {"MOTION_WRONG_CONTROLLER", intaglio_MOTION_WRONG_CONTROLLER}};
  for (const auto& [known, fault] : kFaults) {
    if (name == known) return fault;
  }
  return intaglio_MOTION_OK;
}

}  // namespace

StageStandIn::StageStandIn(bus::Bus& bus, std::string cell, std::string instance)
    : cell_(std::move(cell)),
      batches_(bus, bus::kMotionSegmentBatch, cell_),
      states_(bus, bus::kMotionState, cell_),
      credit_(bus, std::move(instance), bus::RolePartition(bus::CellRole(cell_))) {}

void StageStandIn::Fail(const std::string& fault, const std::string& message) {
  fault_ = FaultOf(fault);
  message_ = message;
  at_rest_ = at_rest_ || fault_ != intaglio_MOTION_OK;
  changed_ = true;
}

void StageStandIn::Begin(const SegmentWords& words) {
  EndStream();
  run_ = words.run;
  start_tick_ = words.start_tick;
  subticks_ = 0;
  whole_ = at_rest_ = false;
  fault_ = intaglio_MOTION_OK;
  message_.clear();
  stream_ = bus::StreamName(words.job_uid, run_, bus::kMotionSegmentBatch.name);
  (void)credit_.Open(stream_, batches_.guid(), kSegmentWindowBatches);
}

void StageStandIn::EndStream() {
  if (!stream_.empty()) (void)credit_.Close(stream_);
  stream_.clear();
}

bool StageStandIn::Take(CellListener& listener) {
  bool begun = false;
  batches_.TakeAll([&](const intaglio_MotionSegmentBatch& sample,
                       const bus::SampleOrigin& origin) {
    if (!origin.alive) return;
    const SegmentWords words = WordsOf(sample);
    begun = listener.Take(words, static_cast<std::uint64_t>(origin.source_ns)) || begun;
    changed_ = true;
    if (words.abort) {
      if (words.run < run_) return;
      run_ = words.run;
      at_rest_ = true;
      return EndStream();
    }
    if (words.run > run_) Begin(words);
    if (words.run != run_ || stream_.empty()) return;
    for (const std::uint32_t subticks : words.duration_subticks) subticks_ += subticks;
    whole_ = words.last;
    (void)credit_.Consumed(stream_, words.number + 1);
    if (whole_) EndStream();
  });
  return begun;
}

bool StageStandIn::Turn(std::chrono::nanoseconds now, std::uint64_t tick,
                        CellListener& listener) {
  const bool begun = Take(listener);
  if (!at_rest_ && whole_ && tick >= start_tick_ + subticks_ / kSubticksPerTick)
    at_rest_ = changed_ = true;
  if (changed_ || now >= next_state_) {
    changed_ = false;
    next_state_ = now + kStatePeriod;
    Tell(tick);
  }
  return begun;
}

void StageStandIn::Tell(std::uint64_t tick) {
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
  (void)states_.Write(sample);
}

}  // namespace intaglio::replayer
