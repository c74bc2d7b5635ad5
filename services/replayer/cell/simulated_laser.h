#pragma once

// A laser controller at the other end of a pseudo-terminal, whose pulses end as
// commanded. Lamp, shutters, decided ticks and interlocks are those of the virtual laser;
// its ticks pass as far as they are decided and no further than the next armed tick whose
// end is not known yet. From one thread; nothing blocks.

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "proto/machine.pb.h"
#include "services/virtual_engraver/laser.h"
#include "services/virtual_engraver/laser_end.h"
#include "services/virtual_engraver/lines/pty_line.h"

namespace intaglio::replayer {

enum class PulseEnd { kSeen, kUnseen, kNotInPosition };
/// Asked for each armed tick when its turn comes, with how many are armed from it on;
/// nothing: it does not come yet.
using EndOfPulse = std::function<std::optional<PulseEnd>(std::size_t armed_count)>;

class SimulatedLaser {
 public:
  /// `link`: symbolic link to make for the line. kIo.
  static Result<std::unique_ptr<SimulatedLaser>> Make(const std::filesystem::path& link,
                                                      const MachineSpec& machine);
  void Turn(std::chrono::nanoseconds now, const EndOfPulse& end_of_pulse);
  virtual_engraver::Laser& laser() { return laser_; }

 private:
  SimulatedLaser(virtual_engraver::PtyLine line, virtual_engraver::LaserOptions options);
  void PollLine();
  void Note(link::LaserFrame type, std::span<const std::byte> payload);
  bool PassTick(const EndOfPulse& end_of_pulse);

  virtual_engraver::PtyLine line_;
  virtual_engraver::Laser laser_;
  virtual_engraver::LaserEnd end_{laser_};
  std::deque<std::uint64_t> armed_;  // ticks that are to fire and have not passed
};

}  // namespace intaglio::replayer
