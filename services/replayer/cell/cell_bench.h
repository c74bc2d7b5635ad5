#pragma once

// The place at which a synchronizer works: job service, sorter, motion bridge and laser
// are played from a session. The machine's time is the recording's clock: what happened
// at some pulse of some run happens there again, and the laser does not pass that pulse
// before. So nothing depends on how fast this host is, and a session of hours, or one
// that was recorded in lockstep, takes as long as its planning.
//
//   before run k: every event that came before it, one after the other
//   in run k:     each armed point ends as the one at its place in that run did then;
//                 events come when as many points have ended as had then
//   a run that was broken off ends where the machine's decisions ended: the laser waits
//   there until the event that broke it off has been sent, and the run is aborted. When
//   no recorded event broke it off (a message came too late, a line fell silent), the
//   permission is not renewed there
//
// One task at a time, from one thread.

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "services/platform/bus/flow.h"
#include "services/replayer/cell/cell_session.h"
#include "services/replayer/cell/simulated_laser.h"
#include "services/replayer/cell/simulated_stage.h"
#include "services/replayer/rehearsal.h"
#include "services/replayer/stage_input.h"

namespace intaglio::replayer {

class CellBench {
 public:
  /// `laser` lives longer.
  CellBench(bus::Bus& bus, const recording::McapReader& reader, const std::string& cell,
            SimulatedLaser& laser);

  /// Waits for the synchronizer; its software version. kTimedOut.
  Result<std::string> FindService(const KeepOn& keep_on);

  /// Why the run cannot be continued; empty: it can.
  struct Stillness {
    std::string why;
    bool by_recording = false;  ///< the recording ends here; false: the synchronizer does
                                ///< not go on
  };
  struct Performed {
    CellMessages messages;
    Stillness stillness;
    std::size_t run_count = 0;  ///< recorded runs that were begun
  };
  /// `frozen_job`: as it is given now.
  Result<Performed> Perform(const CellSession& session, const std::string& frozen_job,
                            const KeepOn& keep_on);

 private:
  using Clock = std::chrono::steady_clock;
  struct Performance;

  Status Give(const Performance& performance, bool revoked, bool take_up);
  Status Turn(Performance& performance);
  void TakeMessages(Performance& performance);
  void BeginRun(Performance& performance);
  void DeliverDue(Performance& performance);
  bool IsDue(const Performance& performance) const;
  void Deliver(Performance& performance, const CellEvent& event);
  void SetInterlocks(const InterlockMessage& message);
  bool BreaksOff(const Performance& performance) const;
  bool HoldsBack(const Performance& performance) const;
  void KeepPermission(Performance& performance, bool at_once);
  std::optional<PulseEnd> EndOfPulse(Performance& performance, std::size_t armed) const;
  static bool AllAreReported(const Performance& performance);
  bool RunIsOver(const Performance& performance) const;
  Stillness WhyNothingMore(const Performance& performance) const;
  Status Finish(Performance& performance, const KeepOn& keep_on);

  const recording::McapReader& reader_;
  SimulatedLaser& laser_;
  std::string instance_;
  std::string cell_;
  bus::Writer<intaglio_StageTask> tasks_;
  bus::Writer<intaglio_PathBatch> path_;
  bus::Writer<intaglio_Permission> permissions_;
  bus::Writer<intaglio_EmergencyStop> stops_;
  bus::Reader<intaglio_ServiceHealth> health_;
  bus::Reader<intaglio_TaskStatus> status_;
  bus::Reader<intaglio_PulseEventBatch> pulses_;
  bus::CreditBook book_;
  SimulatedStage stage_;
  bus::WaitSet wait_;
  std::uint64_t permission_number_ = 0;
};

}  // namespace intaglio::replayer
