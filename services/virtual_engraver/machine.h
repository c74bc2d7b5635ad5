#pragma once

// The whole machine: two lines, stage, laser, beam, glass, and the clock that drives
// them. One thread; time comes from an injected clock.
//
// Lockstep: a tick passes only if the host has decided it and the stage has motion for it
// (or none to come); so ticks pass as fast as the data comes, and nothing starves. Real
// time: ticks pass by the clock, `speed` times as fast as the lamp's rate, and data sent
// on a line arrive up to `line_jitter` later.
//
// With one line both protocols are on it; it has one host and one session.
//
// A safe state of its own: no valid frame on the laser line for 250 ms while a shutter is
// open or a tick is decided closes the shutters; on the motion line during a run it stops
// the stage. In lockstep silence has no length: only a line whose host has closed it, or
// that is unplugged, is lost.

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "services/virtual_engraver/beam.h"
#include "services/virtual_engraver/bodies.h"
#include "services/virtual_engraver/glass.h"
#include "services/virtual_engraver/laser.h"
#include "services/virtual_engraver/laser_end.h"
#include "services/virtual_engraver/lines/device_line.h"
#include "services/virtual_engraver/positioner.h"
#include "services/virtual_engraver/stage.h"
#include "services/virtual_engraver/stage_end.h"
#include "services/virtual_engraver/stations.h"

namespace intaglio::virtual_engraver {

struct MachineOptions {
  StageOptions stage;
  LaserOptions laser;
  BlockInMachine block;
  std::vector<StationInMachine> further_stations;
  PositionerOptions positioner;
  BodyOptions bodies;
  double crack_length_mm = 0.2;  ///< of the laser's largest pulse, along the beam
  double split_ratio = 1;        ///< of a pulse, in the beam of each channel
  double wavelength_mm = 0.532e-3;
  double crack_energy_mj = 0;  ///< the least that an upright beam cracks the glass with
  /// How far beside that of channel 1 the beam of each channel meets.
  std::array<Vec3, 4> channel_offset_mm = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(),
                                           Vec3::Zero()};
  double speed = 1;  ///< machine time against real time; ignored in lockstep
  std::chrono::nanoseconds line_jitter{0};  ///< 0..2 ms; ignored in lockstep
  unsigned seed = 0;                        ///< of the jitter
};

class Machine {
 public:
  Machine(const MachineOptions& options, Glass glass, link::SteadyClock clock);

  /// A line is plugged in: the machine's end of it. Null unplugs it.
  void PlugLaserLine(std::unique_ptr<link::ByteStream> end);
  void PlugMotionLine(std::unique_ptr<link::ByteStream> end);
  /// One line for both: a controller that moves the stage and switches the laser.
  void PlugOneLine(std::unique_ptr<link::ByteStream> end);

  /// Lines, ticks that are due, reports. Returns how long nothing is due.
  std::chrono::nanoseconds Turn();

  Laser& laser() { return laser_; }
  Stage& stage() { return stage_; }
  Glass& glass() { return glass_; }
  /// The next pulses make no crack.
  void MissPulses(std::uint64_t count) { to_miss_ += count; }
  /// The photosensors of these channels, or of all, see none of the next flashes.
  void BlindSensor(std::uint64_t count, std::uint8_t channels = 0x0f) {
    to_overlook_ += count;
    blind_channels_ = channels;
  }
  /// No tick behind this one passes before another is set: something happens there.
  void StopAt(std::uint64_t tick) { stop_at_ = tick; }
  /// The next lamp sync comes `seconds` of machine time late.
  void DelaySync(double seconds);
  /// Everything about the present moment as one line of JSON.
  std::string StatusLine();

 private:
  std::unique_ptr<link::ByteStream> Delayed(std::unique_ptr<link::ByteStream> end);
  void PollLines();
  void AdvanceJog();
  void KeepSafe();
  bool MayPassTick() const;
  bool PassTicks();
  void PassTick();
  /// The stage has moved: what meets now?
  void FeelBodies();
  void Fire(std::uint8_t channels, const Vec3& place_mm);
  void SendReports(bool at_once);
  /// Lamp off, shutters closed, stage at rest without a run: nothing happens before a
  /// host commands it. In lockstep never: there the host waits for the machine.
  bool Rests() const;
  /// Until the next status of a machine that rests.
  std::chrono::nanoseconds RestingIdle() const;

  MachineOptions options_;
  Stage stage_;
  Laser laser_;
  Glass glass_;
  Bodies bodies_;
  link::SteadyClock clock_;
  LaserEnd laser_end_{laser_};
  StageEnd stage_end_{stage_, [this] { AdvanceJog(); }};
  bool one_line_ = false;
  unsigned lines_plugged_ = 0;
  std::chrono::nanoseconds next_tick_at_;
  std::chrono::nanoseconds jogged_at_{0};  // until when the stage was moved by hand
  std::uint64_t stop_at_ = UINT64_MAX;
  std::uint64_t to_miss_ = 0, to_overlook_ = 0;
  std::uint8_t blind_channels_ = 0;
  double sync_late_s_ = 0;
  bool rested_ = false;  ///< at the newest report
};

}  // namespace intaglio::virtual_engraver
