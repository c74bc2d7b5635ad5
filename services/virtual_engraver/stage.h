#pragma once

// The controller of a stage: executes runs of position-velocity-time segments on the
// clock of the lamp's ticks or on one of its own. What it moves lags behind what is
// commanded (StageAxes). Machine frame, mm.
//
//   rest --BeginRun--> waiting for the start --> running --end of program--> rest
//                                                       |  fault, abort
//                                                       +----> braking ----> rest
//   rest --Jog, Home, MoveBlock--> jogging --at the place, or braked--> rest
//   any --drives cut--> rest
//
// With a clock of its own it knows of a tick only by a notice, which arrives a while
// later; knots come with times of its clock, and its in-position output is on around
// them. Its position is taken when the notice arrives.
//
// A stage that carries the block under it moves while the axes rest alone, and a run
// begins and goes on with the block at the place of the run alone.
//
// Not thread-safe; the time is that given to AdvanceTick.

#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "services/platform/link/motion_protocol.h"
#include "services/virtual_engraver/axes/stage_axes.h"
#include "services/virtual_engraver/block_stage.h"
#include "services/virtual_engraver/home_course.h"
#include "services/virtual_engraver/jog_course.h"
#include "services/virtual_engraver/mechanics/mechanics.h"
#include "services/virtual_engraver/mechanics/vibration.h"
#include "services/virtual_engraver/own_clock.h"

namespace intaglio::virtual_engraver {

inline constexpr std::uint64_t kSubticksPerTick = 65536;
/// The motion line counts in nm.
inline constexpr double kNmPerMm = 1e6;

struct StageOptions {
  Vec3 travel_min_mm = Vec3::Zero();
  Vec3 travel_max_mm = Vec3::Constant(170);
  /// Where the axes are at power-up and at home; within the travel the nearest place.
  Vec3 start_mm = Vec3::Zero();
  MechanicsOptions mechanics;  ///< of each axis
  std::optional<VibrationOptions> vibration = {};
  double repeatability_mm = 0;  ///< of every place it goes to, each axis
  unsigned repeatability_seed = 0;
  Vec3 backlash_mm = Vec3::Zero();      ///< of each axis, >= 0
  double position_tolerance_mm = 0.01;  ///< of the in-position output, distance
  /// How far the focus goes for a unit of each axis: what is in rad is compared in mm.
  Vec3 focus_per_axis_unit_mm = Vec3::Ones();
  double following_error_limit_mm = 1;  ///< beyond it the stage stops with a fault
  double brake_acceleration_mm_s2 = 7000;
  /// With this x and y come to rest where they are mirrors, within their travel; 0: they
  /// are none.
  double mirror_brake_mm_s2 = 0;
  std::uint32_t queue_capacity = 4096;  ///< segments
  bool waits_for_motion = false;        ///< lockstep: an empty queue is no fault
  std::optional<OwnClockOptions> own_clock = {};  ///< none: it runs on the lamp's ticks
  std::string serial_number = "virtual-stage-1";  ///< empty: it has none
  bool floats_on_air = false;                     ///< it watches its compressed air
  /// One count of the velocities on its line, >= 1: 100 is enough for 210 m/s.
  std::uint32_t velocity_unit_nm_s = 1;
  std::optional<BlockStageOptions> block_stage = {};  ///< none: the block rests
  /// No axis, > 0, is faster: a segment that is ends the run (kTooFast), and a jog is
  /// slower.
  Vec3 max_speed_mm_s = Vec3::Constant(std::numeric_limits<double>::infinity());
  /// None: its encoders are absolute. Else it knows its place from the end of Home until
  /// its drives are cut or a switch is met, and only then does a run or a jog begin.
  std::optional<HomingOptions> homing = {};
};

/// start_mm, within the travel.
Vec3 StartMm(const StageOptions& options);

class Stage {
 public:
  /// With the axes of the virtual engraver, as the options have them.
  explicit Stage(const StageOptions& options);
  /// What the options have of virtual axes has no effect. `axes` is not null, and is at
  /// rest at StartMm(options).
  Stage(const StageOptions& options, std::unique_ptr<StageAxes> axes);

  void BeginRun(const link::BeginRun& run);
  void Append(const link::Segments& segments);
  /// In their place for a controller with a clock of its own.
  void BeginTimedRun(const link::BeginTimedRun& run);
  void AppendTimed(const link::TimedSegments& segments);
  void Abort() { Brake(link::StageFault::kNone); }
  /// By hand, see JogMove in the protocol. AdvanceJog moves it, not AdvanceTick.
  void Jog(const link::JogMove& jog);
  void Home();
  /// The stage that carries the block, by hand; see the protocol. AdvanceJog moves it.
  void MoveBlock(const link::MoveBlock& move);
  /// Somebody pushes it. A run that goes on ends with the fault kBlockPlace.
  void PushBlock(const Vec2& by_mm);
  /// By its own axes; 0: there is none.
  Vec2 block_mm() const { return block_ ? block_->at_mm() : Vec2::Zero(); }
  bool jogging() const { return phase_ == Phase::kJogging; }
  /// The time that has passed since the last call, s.
  void AdvanceJog(double seconds);
  /// Stops the stage, with a fault that has to be reset.
  void Fail(link::StageFault fault) { Brake(fault); }
  void Reset();
  /// What cuts the drives now: kStopPressed, kDriveFault; kNone: they are in order. The
  /// axes rest at once, their place is lost, and no Reset clears the fault before.
  void SetDrives(link::StageFault cause);
  /// Its compressed air: without it a stage that floats on it stops with kNoAir, and with
  /// it again the fault is kAirReturned, which Reset clears.
  void SetAir(bool on);
  /// An axis that does not move any more (-1: all of them), until Unstick.
  void Stick(int axis) { axes_->Stick(axis); }
  void Unstick() { axes_->Unstick(); }

  /// Whether the tick after the present one may pass in lockstep: motion for it is here,
  /// or none is to come. It will last 1 / rate_hz.
  bool MayPass(double rate_hz) const;
  /// One tick of 1 / rate_hz later. Latches the position while a run is executed.
  void AdvanceTick(double rate_hz);

  /// In place of AdvanceTick and AdvanceJog, for a controller whose own clock is a real
  /// one: it has come to this time, not before the time of the last call.
  void AdvanceClock(std::uint64_t now_ns);
  /// The newest lamp sync that it was notified of, of a lamp with this rate, was at this
  /// time of its clock; the place of now is latched for it.
  void ReceiveTick(std::uint64_t tick, std::uint64_t at_ns, double rate_hz);

  /// At the present tick: a segment marked for a pulse ends here, and the stage is there.
  /// On a clock of its own, "here" is within 0.35 ms and a quarter of a tick. There,
  /// where the stage is to be is the end less its lag times its velocity there; with
  /// second-order mechanics, control loops and a drive for each axis where its
  /// controller's model of them is.
  bool in_position() const { return in_position_; }
  /// As its encoders measure it.
  const Vec3& actual_mm() const { return axes_->actual_mm(); }
  /// Where it is when its compare output comes on in the tick that begins now: nearest to
  /// the knot of this tick that is marked for a pulse. Nothing when it does not pass
  /// within the tolerance before the next tick, or runs on a clock of its own.
  std::optional<Vec3> PlaceOfCompare() const;
  /// Where it is: the actual position and what backlash, vibration and repeatability add.
  Vec3 place_mm() const;
  /// Since power-up, modulo 2^32.
  std::uint32_t runs_begun() const { return runs_begun_; }
  bool running() const { return phase_ != Phase::kRest; }
  link::StageFault fault() const { return fault_; }
  link::MotionStatus Report();
  link::MotionIdentity Identity() const;
  link::StageTolerance Tolerance() const;
  /// None: every speed that the line carries is taken.
  std::optional<link::StageSpeed> MaxSpeed() const;
  /// Positions latched since the last call.
  std::vector<link::Positions> TakePositions() { return std::exchange(latched_, {}); }
  std::vector<link::TimedPositions> TakeTimedPositions() {
    return std::exchange(timed_latched_, {});
  }
  /// Null: it runs on the lamp's ticks.
  OwnClock* own_clock() { return own_clock_ ? &*own_clock_ : nullptr; }

 private:
  enum class Phase { kRest, kRunning, kBraking, kJogging };
  /// What is queued; times in units: subticks, or ns of the controller's own clock.
  struct Piece {
    Vec3 end_mm = Vec3::Zero(), end_mm_s = Vec3::Zero();
    std::uint64_t units = 0;
    bool pulse = false, program_end = false;
  };
  struct Knot {
    Vec3 at_mm = Vec3::Zero();   // where the stage is to be, see PlaceOf
    Vec3 end_mm = Vec3::Zero();  // of its segment
    std::uint64_t at_units = 0;
    bool pulse = false;
  };
  /// From a knot.
  static CubicCommand CurveOf(const Vec3& p0, const Vec3& v0, const Vec3& p1,
                              const Vec3& v1, double duration_s);
  bool Refuses(bool timed);
  /// Fails where the block is not at the place that the run needs.
  bool RefusesPlace(std::int32_t block_x_nm, std::int32_t block_y_nm);
  bool IsBlockAt(const Vec2& place_mm) const;
  void BrakeJog();
  void Start(std::uint32_t run, std::uint64_t start_units);
  bool TakesSegments(std::uint32_t run, std::uint64_t first_number, std::size_t count);
  bool Queue(const Piece& piece);
  void Brake(link::StageFault fault);
  /// How long x and y, and z take to rest, s.
  Vec3 StopSeconds() const;
  /// The part of the way to rest between two times, s from now.
  Piece StopPiece(const Vec3& stop_s, double from_s, double to_s) const;
  void FollowCurve(const CubicCommand& curve, double from_s, double to_s);
  /// At most `units`; what the queue did not cover is returned.
  std::uint64_t FollowQueue(std::uint64_t units);
  void AdvanceTo(std::uint64_t units);
  void AdvanceOwnClock();
  void FinishPiece();
  double DoneRatio() const;
  class Ahead;
  bool GateIsOn() const;
  Vec3 PlaceOf(const Piece& piece) const;
  bool IsAt(const Vec3& place_mm) const;
  Vec3 AtFocus(const Vec3& axes) const {
    return axes.cwiseProduct(options_.focus_per_axis_unit_mm);
  }
  void Latch();
  void LatchAt(const OwnClock::Received& received);
  void StartJog(const Vec3& target, double speed_mm_s);
  /// Fails the run where the axes may be anywhere.
  bool RefusesWithoutPlace(std::uint32_t run);
  void StartHoming();
  void AdvanceHome(double seconds);
  void EndHomeLeg();
  /// Here, as it is commanded now.
  void Rest();
  void CheckSwitches();
  /// The in-position output and the following error of now.
  void CheckPlace();

  StageOptions options_;
  std::optional<OwnClock> own_clock_;
  Phase phase_ = Phase::kRest;
  link::StageFault fault_ = link::StageFault::kNone;
  bool has_air_ = true;  // or needs none
  std::uint64_t tick_ = 0;
  std::uint64_t received_tick_ = 0;  // with a clock of its own: the newest it knows of
  double rate_hz_ = 1;
  double unit_s_ = 1;
  std::uint64_t now_units_ = 0;
  std::uint32_t run_ = 0, runs_begun_ = 0;
  std::uint64_t start_units_ = 0;
  std::uint64_t taken_ = 0;
  std::uint64_t last_end_ns_ = 0;
  std::deque<Piece> queue_;
  std::uint64_t queued_units_ = 0;    // of the whole queue
  std::uint64_t in_piece_units_ = 0;  // done of its first piece
  Knot passed_;                       // the last one of this run
  Vec3 knot_mm_ = Vec3::Zero(), knot_mm_s_ = Vec3::Zero();
  Vec3 commanded_mm_ = Vec3::Zero(), commanded_mm_s_ = Vec3::Zero();
  std::unique_ptr<StageAxes> axes_;
  bool in_position_ = false;
  double following_error_max_mm_ = 0;
  // While phase_ is kJogging one of them, or the block's stage moves.
  std::optional<JogCourse> jog_;
  std::optional<HomeCourse> home_;
  bool knows_place_;
  link::StageFault drives_ = link::StageFault::kNone;
  std::array<bool, 3> fault_axes_ = {};  // what the fault is of, where it is of some
  std::uint32_t jogs_taken_ = 0;
  std::optional<BlockStage> block_;
  Vec2 run_block_mm_ = Vec2::Zero();  // where the run needs it
  std::vector<link::Positions> latched_;
  std::vector<link::TimedPositions> timed_latched_;
};

}  // namespace intaglio::virtual_engraver
