#pragma once

// The bus side of motion by hand and of teaching, in the process that has the line to the
// controller: takes ManualCommand and CellMove, gives them to ManualControl, has a
// Teacher save what is taught, and publishes ManualState.
//
// A teaching is saved only while the stage is at rest, no run is active and the job
// service answers that no job is armed: a job is engraved with the zero that it began
// with. Saving writes to the disk, which may take longer than the motion line's patience;
// at rest that ends nothing.
//
// Where a controller may have lost its place, a zero that is taught is not saved: the
// controller counts the place of the zero that was taught before from then on, so all
// that was taught, and a job that has begun, fit again.

#include <chrono>
#include <cstdint>
#include <string>

#include "services/cell/manual/manual_control.h"
#include "services/cell/manual/teacher.h"
#include "services/platform/bus/bus.h"

namespace intaglio::cell {

class ManualDesk {
 public:
  /// `motion` and `teacher` outlive this.
  ManualDesk(bus::Bus& bus, const std::string& cell, drivers::HandMotion& motion,
             Teacher& teacher);

  /// Once a turn, after the driver was polled.
  void Turn(bool run_active, bool stop_pressed, std::chrono::nanoseconds now);
  bool moves() const { return control_.moves(); }

  bus::Reader<intaglio_ManualCommand>& commands() { return commands_; }
  bus::Reader<intaglio_ManualCommand>& cell_moves() { return cell_moves_; }
  bus::Reader<intaglio_Interlock>& interlocks() { return interlocks_; }

 private:
  void TakeConditions(std::chrono::nanoseconds now);
  void TakeCommands(bus::Reader<intaglio_ManualCommand>& reader, bool by_cell,
                    std::chrono::nanoseconds now);
  void Teach(const ManualOrder& order, const intaglio_ManualCommand& command,
             std::chrono::nanoseconds now);
  void TakeAtZero(ManualOrder order, const intaglio_ManualCommand& command,
                  std::chrono::nanoseconds now);
  std::string WhyNoTeaching() const;
  void Publish(std::chrono::nanoseconds now);

  std::string cell_;
  drivers::HandMotion& motion_;
  Teacher& teacher_;
  TaughtAxes axes_;
  ManualControl control_;
  bus::Reader<intaglio_ManualCommand> commands_, cell_moves_;
  bus::Reader<intaglio_Interlock> interlocks_;
  bus::Reader<intaglio_Permission> permissions_;
  bus::Writer<intaglio_ManualState> states_;
  ManualConditions conditions_;
  std::chrono::nanoseconds permission_at_{-1}, commanded_at_{-1}, next_state_{0};
  std::uint64_t number_;
};

}  // namespace intaglio::cell
