#pragma once

// The bus side of motion by hand and of teaching: takes ManualCommand and CellMove, gives
// them to ManualControl, saves what is taught in the profile, and publishes ManualState.
//
// A teaching is saved only while the stage is at rest, no run is active and the job
// service answers that no job is armed: a job is engraved with the zero that it began
// with. Saving writes to the disk, which may take longer than the motion line's patience;
// at rest that ends nothing.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "proto/machine.pb.h"
#include "services/motion_bridge/manual/manual_control.h"
#include "services/platform/bus/bus.h"

namespace intaglio::motion_bridge {

class ManualDesk {
 public:
  /// `profile`: the file that `machine` was read from. `driver` outlives this.
  ManualDesk(bus::Bus& bus, const MachineSpec& machine, std::filesystem::path profile,
             drivers::MotionDriver& driver);

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
  void GoToZero(ManualOrder order, const intaglio_ManualCommand& command,
                std::chrono::nanoseconds now);
  Result<std::string> Save(const intaglio_ManualCommand& command);
  std::string WhyNoTeaching() const;
  void ReadProfile();
  void Publish(std::chrono::nanoseconds now);

  std::string cell_;
  std::filesystem::path profile_;
  MachineSpec machine_;
  drivers::MotionDriver& driver_;
  ManualControl control_;
  bus::Reader<intaglio_ManualCommand> commands_, cell_moves_;
  bus::Reader<intaglio_Interlock> interlocks_;
  bus::Reader<intaglio_Permission> permissions_;
  bus::Writer<intaglio_ManualState> states_;
  ManualConditions conditions_;
  std::chrono::nanoseconds permission_at_{-1}, interlock_at_{-1}, commanded_at_{-1},
      next_state_{0};
  std::uint64_t number_;
};

}  // namespace intaglio::motion_bridge
