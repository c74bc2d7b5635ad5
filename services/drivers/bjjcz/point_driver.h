#pragma once

// Points in glass by a BJJCZ board (LMC, of EzCad 2): motion_line.protocol "bjjcz", of a
// machine with head_over_block.jump_and_dwell. docs/machines/bjjcz.md has wiring and
// settings.
//
//   segments --PieceQueue--> pieces --PointLists--> a list --LmcLine--> board
//   decided ticks --ProgressTicks--^                  | BUSY is gone
//                                  the list's points are made, its ticks pass
//
// One list of at most kMaxListSeconds is in the board; the next is given when BUSY of it
// has gone. A point is a jump, its delay, and the laser on at rest. A list has one power
// (laser.energy_calibration), so it ends where the energy changes. z is the board's axis
// and moves between lists alone: where a piece has another z, the list before it is
// played first. The end of a move is the board's (AXIS), its place is read and compared.
//
// An outline of the guide laser (guide_output) is a jog without an end: lists of jumps
// alone, behind a dark one to its first corner. While it is drawn the gate output stays
// off, whatever the laser's side wants, and a fibre laser's oscillator is off.
//
// What it shares with other controllers that have no clock: lockstep_driver.h.
//
// What this family does not keep by itself of the numbered guarantees, and what bounds
// it:
//  - M9, L7: there is no watchdog. A board whose host is gone plays its list to the end,
//    kMaxListSeconds at most, and the gate output stays on: an external gate has to cut
//    the laser for key, door and stop button. Of an outline the guide laser stays on, at
//    rest, until the line is back (M19).
//  - M2: behind a list that was stopped, or lost, position_mm has the place where it
//    would have ended, until the next one ends.
//  - L6: the points of the list that was executed when the line was lost, or when the
//    shutter was closed, are uncertain.
//  - L9: key, door and stop button are one chain at an input that is read every 5 ms;
//    shorter openings, and those without a host, are not seen.
//  - M11, L11: it gives no number of its power-up. A session in which the axis counts
//    where it did before is of the same one; any other is another.
//  - M18: the axis counts from 0 at its power-up, so an axis that reads 0 when a session
//    begins has to be homed. Its origin is 1 mm below the travel of z, and a homed axis
//    never rests there. Once its place is lost, or its origin is searched, only an origin
//    that was found makes it known again; what another program has done with the axis, or
//    a home that ended with this process, is not known: home it behind one.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/board_list.h"
#include "services/drivers/bjjcz/guide_outline.h"
#include "services/drivers/bjjcz/lmc_line.h"
#include "services/drivers/bjjcz/point_lists.h"
#include "services/drivers/lockstep/lockstep_driver.h"
#include "services/drivers/lockstep/tick_powers.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class BjjczPointDriver final : public LockstepDriver {
 public:
  /// `broken`: what is wrong with the profile; then no board is right. Empty: nothing is.
  BjjczPointDriver(const MachineSpec& machine, std::vector<LmcCommand> set_up,
                   std::string broken, link::StreamOpener open, link::SteadyClock clock);

  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override;

 private:
  /// What has passed when the list has ended.
  struct Step {
    std::optional<Piece> piece;  ///< of a run
    Vec3 from_mm = Vec3::Zero();
    std::uint64_t pulse_tick = 0;  ///< 0: none
  };
  /// A move of the axis.
  struct AxisMove {
    std::int32_t to_steps = 0;
    bool is_to_origin = false;
    bool was_asked = false;  ///< its answer has come
    std::optional<std::chrono::nanoseconds> rests_at = {};
    bool asks_place = false;
  };

  const ControllerLine& line() const override { return line_; }
  PieceQueue& pieces() override { return pieces_; }
  const PieceQueue& pieces() const override { return pieces_; }
  bool IsIdentified() const override {
    return knows_axis_ && knows_inputs_ && LockstepDriver::IsIdentified();
  }
  bool HasSent() const override {
    return playing_.has_value() || axis_.has_value() || stopping_;
  }
  bool IsQuiet() const override { return !busy_ && !moving_; }
  bool IsSettled() const override { return !FirstPulse() && !stopping_; }
  bool HasPending() const override { return held_.has_value() || !lists_.empty(); }
  bool HasRecovered() const override { return line_.up() && closed_ && !stopping_; }
  bool chain_is_open() const override { return !closed_; }
  std::uint32_t openings() const override { return openings_; }
  bool shutter_is_open() const override;
  std::uint64_t LimitedByPulses(std::uint64_t tick) const override;
  bool DwellsAtPoints() const override { return true; }
  Status SetEnergy(const link::ArmWindow& window) override;
  void DropProgram() override;
  void BeginProgram(std::uint64_t start_tick) override;
  void EndRun() override;
  std::uint64_t ForgetSent() override;
  void StopController() override;
  void AskStatus() override { line_.Send({LmcOperation::kReadPort, {}}); }
  void StopHoming() override;

  void TakeAnswers() override;
  void TakeUp();
  void TakeFirstAxisPlace(std::int32_t before);
  void Receive(const LmcAnswer& answer);
  void TakeInputs(std::uint16_t inputs);
  void TakeAxisPlace(std::int32_t steps);
  void TakeEndOfMove(const AxisMove& move);
  void CheckPlace();

  // What is sent: point_driver_feed.cc.
  void Feed() override;
  bool FeedPlayed();
  bool FeedAxis();
  void FeedHome();
  void FeedJog();
  void FeedOutline();
  void FeedRun();
  void FeedAside();
  void FeedOutputs();
  /// Adds it to the list, or says that the list has to be played before.
  bool AddPiece(const Piece& piece);
  void Play();
  void Send(const LmcList& list);
  bool draws_outline() const {
    return outline_ && jog_ && !jog_->cancelled && state_.fault == intaglio_MOTION_OK;
  }
  void MoveAxis(std::int32_t to_steps, double speed_mm_s);
  void TakeEndOfList();
  void Execute(const Step& step);

  std::optional<std::uint64_t> FirstPulse() const;
  unsigned PulsesAt(std::uint64_t tick) const {
    return static_cast<unsigned>(pulses_.At(tick));
  }
  std::int32_t StepsOf(double z_mm) const;
  double HeightOf(std::int32_t steps) const {
    return z_origin_mm_ + steps / steps_per_mm_;
  }
  std::uint16_t WantedOutputs() const;

  BjjczBoard board_;
  double steps_per_mm_, z_mm_s_, z_ramp_s_, z_settle_s_, z_origin_mm_;
  std::string broken_;
  LmcLine line_;
  PieceQueue pieces_;
  PointLists lists_;
  LaserHead laser_;
  TickPowers powers_;
  TickPowers pulses_{0};           ///< of a point, by its tick; 0: those of dwell_s
  Vec3 listed_mm_ = Vec3::Zero();  ///< where the list in hand ends
  Vec3 end_mm_ = Vec3::Zero();     ///< where the newest run ended
  std::optional<Piece> held_;      ///< taken, and not in a list yet
  std::vector<Step> steps_;        ///< of the list in hand, or played
  std::optional<PlayedList> playing_;
  bool is_list_uncertain_ = false;  ///< the gate was closed while it was in the board
  std::optional<AxisMove> axis_;
  std::optional<GuideOutline> outline_;  ///< drawn with jog_, which ends it
  bool stopping_ = false;  ///< until the board reports that it does nothing any more
  bool seen_since_stop_ = false;
  std::uint64_t session_ = 0;
  std::uint32_t openings_ = 0;
  // What is known in the newest session.
  bool knows_inputs_ = false, knows_axis_ = false;
  bool closed_ = false, busy_ = false, moving_ = false, oscillates_ = false;
  std::int32_t axis_steps_ = 0, axis_to_steps_ = 0;  ///< read, and sent to last
  std::optional<std::uint16_t> asked_outputs_, outputs_;
};

std::unique_ptr<MotionDriver> MakeBjjczPointDriver(const MachineSpec& machine,
                                                   link::StreamOpener open,
                                                   link::SteadyClock clock);

}  // namespace intaglio::drivers
