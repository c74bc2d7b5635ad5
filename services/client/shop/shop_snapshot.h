#pragma once

// A shop as it is on the bus at one moment.

#include <map>
#include <string>
#include <vector>

#include "services/client/job_client.h"
#include "services/platform/bus/bus.h"

namespace intaglio::client {

/// Interlock, LampSync and MotionState of one machine, copied.
struct CellSnapshot {
  bool has_interlock = false;
  bool laser_line_up = false, key_on = false, door_closed = false, door_locked = false,
       stop_released = false;
  bool lamp_on = false, lamp_warm = false, safe_state = false;
  std::uint8_t shutters_open = 0;
  bool stop_pressed = false;            ///< on the bus
  std::vector<std::string> stops_held;  ///< its presses, "SOURCE (number N)"
  bool has_lamp = false;
  double warm_ratio = 0, rate_hz = 0;
  bool has_motion = false;
  intaglio_MotionFault motion_fault = intaglio_MOTION_OK;
  std::string motion_message;
  double x_mm = 0, y_mm = 0, z_mm = 0;
  bool at_rest = false;
  bool has_block_stage = false;
  double block_x_mm = 0, block_y_mm = 0;  ///< of its own axes
};

struct ShopSnapshot {
  std::vector<ServiceView> services;
  std::vector<JobView> jobs;
  std::vector<DiskView> disks;
  std::map<std::string, CellSnapshot> cells;  ///< by name
  std::map<std::string, MountView> mounts;    ///< by machine
};

/// Follows a shop. Used from one thread.
class ShopWatcher {
 public:
  explicit ShopWatcher(bus::Bus& bus);
  /// Takes what comes within `time`.
  void Poll(std::chrono::milliseconds time);
  /// All that a working shop has is here: the services that its job service lists, its
  /// jobs and its disks, and of every machine with a synchronizer its interlocks, of
  /// every one with a bridge its motion.
  bool IsComplete() const;
  ShopSnapshot Take() const;
  /// For commands.
  JobClient& client() { return client_; }

 private:
  void TakeCells();

  JobClient client_;
  bus::Reader<intaglio_Interlock> interlocks_;
  bus::Reader<intaglio_LampSync> lamps_;
  bus::Reader<intaglio_MotionState> motion_;
  std::map<std::string, CellSnapshot> cells_;
};

}  // namespace intaglio::client
