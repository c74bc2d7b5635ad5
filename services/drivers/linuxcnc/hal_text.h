#pragma once

// The texts that pass between the driver and LinuxCNC's HAL: rows and commands in the
// form of halstreamer, samples in the form of `halsampler -t`, and the two files that the
// configuration of deploy/linuxcnc keeps in its folder. Columns: deploy/linuxcnc/*.hal.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::drivers {

/// One servo period. The numbers `arm` and `motion` have to be those of the newest
/// command: else the row fires nothing, or the axes do not follow it.
struct HalRow {
  std::uint32_t tick = 0;                         ///< lamp period that the row lies in
  std::uint64_t number = 0, arm = 0, motion = 0;  ///< below 2^51
  bool fire = false, gated = false;
  Vec3 position_mm = Vec3::Zero();  ///< machine frame
};
/// Whole lines, appended.
void AppendText(const HalRow& row, std::string& text);

struct HalCommand {
  std::uint64_t number = 0, arm = 0, motion = 0;  ///< below 2^51
  bool heartbeat = false, stop = false, wake = false, laser_reset = false,
       motion_reset = false, shutter = false, lamp = false;
  std::uint64_t periods = 0;  ///< of a tick; HAL only reports it
};
void AppendText(const HalCommand& command, std::string& text);

enum HalFlags : std::uint32_t {
  kHalFresh = 1 << 0,  ///< a row was played in this period
  kHalFire = 1 << 1,
  kHalLaser = 1 << 2,  ///< the laser's output
  kHalFlash = 1 << 3,  ///< the photosensor's input
  kHalKey = 1 << 4,
  kHalDoor = 1 << 5,
  kHalStopFree = 1 << 6,
  kHalLaserOk = 1 << 7,   ///< latch of the interlocks
  kHalMotionOk = 1 << 8,  ///< latch of the drives
  kHalWarm = 1 << 9,
  kHalShutter = 1 << 10,
  kHalInPlace = 1 << 11,
  kHalHostAlive = 1 << 12,  ///< the watchdog
  kHalLamp = 1 << 13,
  kHalHomed = 1 << 14,  ///< the axes are where their feedback says
};

/// What one period has done.
struct HalSample {
  std::uint32_t tick = 0;
  std::uint64_t row = 0, row_arm = 0;
  std::uint64_t command = 0, arm = 0, motion = 0;  ///< of the newest command
  std::uint32_t flags = 0;
  Vec3 actual_mm = Vec3::Zero();
  Vec3 target_mm = Vec3::Zero();  ///< that is followed, or held
  std::uint64_t pulses = 0;       ///< since power-up
  std::uint32_t openings = 0;     ///< of key, door and stop button
  std::uint64_t periods = 0;      ///< of the newest command
  bool Has(HalFlags flag) const { return (flags & flag) != 0; }
};
/// One line without its end; nullopt when it is none ("overrun", a torn line).
std::optional<HalSample> ParseSample(std::string_view line);

/// What the laser's output is, by the configuration that HAL was started with.
enum class HalLaser {
  kPulses,  ///< one period long, at rows of their own; each is recorded
  kBeam,    ///< on in all periods whose rows ask for it (start --beam)
};

/// The file `identity`.
struct HalIdentity {
  std::uint32_t power_up = 0;
  std::uint32_t period_ns = 0;  ///< of the servo thread, 50000..10000000
  std::string serial_number;
  HalLaser laser = HalLaser::kPulses;
};
/// kUnreadable with the remedy.
Result<HalIdentity> ParseIdentity(std::string_view text);

/// The whole lines of the file `pulses`: the ticks of all pulses since power-up, in
/// order.
std::vector<std::uint32_t> ParsePulses(std::string_view text);

}  // namespace intaglio::drivers
