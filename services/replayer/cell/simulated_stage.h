#pragma once

// A motion bridge whose stage is at commanded positions: takes runs under credit, rests
// once their ticks have passed or they are aborted. From one thread; nothing blocks.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "engrave/core/geometry.h"
#include "services/platform/bus/flow.h"
#include "services/replayer/cell/cell_messages.h"

namespace intaglio::replayer {

class SimulatedStage {
 public:
  SimulatedStage(bus::Bus& bus, std::string cell, std::string instance);

  /// True when a run has begun. `tick`: of the lamp.
  bool Turn(std::chrono::nanoseconds now, std::uint64_t tick, CellListener& listener);
  /// The stage's position at rest, from now on, machine frame.
  void MoveTo(const Vec3& at_mm) { at_mm_ = at_mm; }
  /// Where the stage that carries the block is from now on, by its own axes, as it was in
  /// each run; none: the machine has no such stage.
  void CarryBlock(const std::optional<Vec2>& at_mm) { block_mm_ = at_mm; }
  /// Until the next run begins; `fault` by name.
  void Fail(const std::string& fault, const std::string& message);
  bool at_rest() const { return at_rest_; }
  bus::Reader<intaglio_MotionSegmentBatch>& reader() { return batches_; }

 private:
  bool Take(CellListener& listener);
  void Begin(const SegmentMessages& messages);
  void EndStream();
  void SendReports(std::uint64_t tick);

  std::string cell_;
  bus::Reader<intaglio_MotionSegmentBatch> batches_;
  bus::Writer<intaglio_MotionState> states_;
  bus::CreditGrantor credit_;
  std::string stream_;
  std::uint32_t run_ = 0;
  std::uint64_t start_tick_ = 0, subticks_ = 0;
  bool whole_ = false, at_rest_ = true;
  Vec3 at_mm_ = Vec3::Zero();
  std::optional<Vec2> block_mm_;
  intaglio_MotionFault fault_ = intaglio_MOTION_OK;
  std::string message_;
  bool changed_ = true;
  std::chrono::nanoseconds next_state_{0};
};

}  // namespace intaglio::replayer
