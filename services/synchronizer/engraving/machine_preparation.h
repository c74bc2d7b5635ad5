#pragma once

// What comes before a run, each time: the right block in the machine, the laser line up,
// the lamp on and warm at the job's rate, the laser controller out of its safe state, the
// state of the stage known.
//
//   Refusal() empty --> a grant: lamp commanded --> warm, rate right --> stage fresh -->
//   WhatIsMissing() empty
//
// The lamp is commanded once in a session: another session may be another power-up, and
// its lamp is off. A safe state and a latched stop are reset only by a grant
// (PermissionChain::may_reset). Used from one thread; nothing waits.

#include <chrono>
#include <cstdint>
#include <string>

#include "services/drivers/interface/laser_controller.h"
#include "services/synchronizer/engraving/engraving_inputs.h"
#include "services/synchronizer/engraving/engraving_job.h"

namespace intaglio::synchronizer {

class MachinePreparation {
 public:
  /// Both outlive this.
  MachinePreparation(const EngravingJob& job, drivers::LaserController& laser)
      : job_(job), laser_(laser) {}

  /// Another block, another device, no line, or a rate, an energy or a lock of the door
  /// that the laser does not have: then nothing is prepared. Empty: none.
  std::string Refusal() const;
  /// Switches the lamp on at the job's rate, unless it is. With a grant alone. True: it
  /// is on, and this job's: nothing else switches it off. One that the job before has
  /// left on is not before that.
  bool LightLamp(std::chrono::nanoseconds now);
  /// `may_reset`: see PermissionChain.
  void LeaveSafeState(bool may_reset, std::chrono::nanoseconds now);
  /// What the machine is not ready for yet, with no refusal; empty: it is ready. `lit`:
  /// the lamp is on, or is being switched on.
  std::string WhatIsMissing(const MotionView& motion, bool lit) const;
  /// Ticks bring it nearer to being ready: they warm the lamp up, and brake the stage. In
  /// lockstep no others pass, so that the first run begins at the same tick however busy
  /// this computer is.
  bool NeedsTicks(const MotionView& motion, bool lit) const;
  /// The lamp is this job's: a grant has switched it on.
  bool has_lamp() const { return lamp_session_ != 0; }
  /// It was ready and is not any more: back to preparing.
  bool is_lost() const {
    return !laser_.up() || !laser_.Has(link::kLampWarm) || !job_.block_misfit.empty();
  }

 private:
  bool LampIsReady() const;
  bool MaySend(std::chrono::nanoseconds now);

  const EngravingJob& job_;
  drivers::LaserController& laser_;
  std::chrono::nanoseconds next_request_{0};
  std::uint64_t lamp_session_ = 0;  // that the lamp was switched on in
};

}  // namespace intaglio::synchronizer
