#pragma once

// The controller of a scan head: it plays blocks of ticks, switches the beam only when it
// may, and remembers what became of marks (services/platform/link/scan_head_protocol.h).
// Time is passed to it tick by tick.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "engrave/formats/mark_record.h"
#include "services/virtual_engraver/head/head_memory.h"
#include "services/virtual_engraver/head/head_physics.h"
#include "services/virtual_engraver/head/web_counter.h"

namespace intaglio::virtual_engraver {

struct HeadOptions {
  HeadPhysicsOptions physics;
  double laser_w = 50;
  std::string serial_number = "virtual-head-1";
  std::uint32_t queue_ticks = 100000;
  std::uint32_t power_up = 1;
  bool lockstep = false;
};

class HeadController {
 public:
  /// `burn` takes what each lit tick burnt, `print` each print mark that passed the photo
  /// eye, without dirt.
  HeadController(const HeadOptions& options,
                 std::function<void(const formats::BurntTick&)> burn,
                 std::function<void(const formats::PrintMark&)> print);

  link::HeadIdentity Identity() const;
  /// A host has come: what another one sent is dropped.
  void NewSession();
  /// The host has gone, or is silent.
  void LoseHost();
  void Permit(bool permitted, std::chrono::nanoseconds now);
  void Begin(const link::HeadBegin& begin);
  void Receive(link::HeadBlock block);
  /// The run ends behind what is queued; without any, at once: in lockstep no tick passes
  /// any more.
  void Finish();
  void Pause();
  void Stop();
  void Reset();
  /// Closes the shutter when the permission is too old; never in lockstep.
  void Watch(std::chrono::nanoseconds now);

  void SetKey(bool on) { Set(key_on_, on); }
  void SetDoor(bool closed) { Set(door_closed_, closed); }
  void SetStopButton(bool pressed) { Set(stop_released_, !pressed); }

  /// One tick later.
  void PassTick();
  bool has_ticks() const { return !queue_.empty(); }
  link::HeadStatus Status() const;
  HeadMemory& memory() { return memory_; }
  /// Since the last call.
  std::vector<link::HeadWeb> TakeWeb();
  std::vector<link::HeadPrint> TakePrints();

 private:
  struct Queued {
    link::HeadBlock block;
    std::size_t next_tick = 0, next_edge = 0;
  };
  void Set(bool& holds, bool now);
  bool interlocked() const { return !key_on_ || !door_closed_ || !stop_released_; }
  void EnterSafeState(link::HeadRunState why);
  void EndRun(link::HeadRunState why);
  bool PassEdges(Queued& queued);
  /// Moved with the web. False: it is lit and outside the field.
  bool FollowWeb(const link::HeadFollow& follow, std::size_t at,
                 link::HeadTick& tick) const;
  void Output(const link::HeadTick& tick);
  void SampleWeb();
  void LatchPrints();

  HeadOptions options_;
  std::function<void(const formats::BurntTick&)> burn_;
  std::function<void(const formats::PrintMark&)> print_;
  HeadPhysics physics_;
  HeadMemory memory_;
  WebCounter web_counter_;
  std::uint64_t tick_ = 0;
  std::deque<Queued> queue_;
  std::uint32_t queued_ticks_ = 0;
  link::HeadTick output_;
  bool key_on_ = true, door_closed_ = true, stop_released_ = true, safe_state_ = false;
  bool permitted_ = false;
  std::chrono::nanoseconds permitted_at_{0};
  bool finishing_ = false, pausing_ = false;
  std::optional<link::HeadEdge> in_hand_;
  std::uint32_t openings_ = 0, drops_taken_ = 0;
  std::uint32_t run_ = 0;
  link::HeadRunState run_state_ = link::HeadRunState::kNone;
  std::uint32_t last_begun_ = link::kNoHeadMark, last_done_ = link::kNoHeadMark;
  link::HeadWeb web_;
  std::uint32_t prints_ = 0;                        // since power-up
  std::vector<link::HeadPrintMark> unsent_prints_;  // the newest of them
};

}  // namespace intaglio::virtual_engraver
