#pragma once

// Marks by a controller of the grbl family (grbl 1.1, grblHAL; serial or TCP): a mill or
// a laser that follows contours. Protocol "grbl-course" of mark_line; course_tool of the
// profile says what its output switches. docs/machines/grbl.md has wiring and settings.
//
//   marks --GrblCourseProgram--> lines --GrblLine--> controller
//                                  |                     |
//                                  v                     v
//             kBegun: before its first line    "ok" of its barrier: kDone
//
// One mark is in hand at a time. It begins when its kBegun was taken, and ends with a
// barrier: "G4P0" is acknowledged when all motion before it was made. A line is sent when
// the one before it was acknowledged, so a line that is refused displaces none behind it;
// and never more than kAhead_s of motion ahead of what the controller is known to have
// executed (Bf of its status, and the blocks of each line).
//
// Frame: G54 of the controller, whose zero a person sets; z up, 0 on the work.
//
// What this family does not keep by itself of the guarantees of mark_driver.h:
//  - K2: there is no watchdog: a controller whose host is gone runs out what it holds. So
//    that is kAhead_s of motion at the speed that was asked for, and one line; a
//    controller that reaches less takes as much longer. Then a laser is dark (M4 mode),
//    and a spindle still turns (M3) until the line comes back: an external gate has to
//    end it. A permission that is withdrawn while the host lives is a Stop, and so is
//    one of a laser that runs out.
//  - K11, of a spindle: no line is sent, so the tool rests behind kAhead_s and a piece. A
//    feed hold ('!') would need '~' to go on, which would also undo the hold of a person
//    at the controller.
//  - K4, Stop: feed hold, and the reset (0x18, which ends beam and spindle) when it is at
//    rest, or after kBraking. A reset in motion may lose the position (ALARM:3).
//  - K6: it remembers no mark. What this object has seen is answered, else kUncertain:
//    one mark at most.
//  - K7: key, door and stop button are one chain on the door's input; of openings without
//    a host one is seen. The inputs of the reset and of grblHAL's emergency stop are the
//    stop button as well.
// shutter_open is that it is permitted: there is no shutter.
//
// What the controller reports of itself is a stop of its own (openings), never a lost
// line: a hold that this host did not ask for, an alarm, a limit, a refused line, also
// when it was found so behind a lost line. Nothing is sent after one before Reset, and
// '~' never is. A reset by another and a power-up are another power_up; so is a new
// object of this class, because the controller gives no number of its own. Where the tool
// is may be unknown then (GrblLine): place_lost lasts until a person has homed it or has
// set its zero, and Begin is refused. Reset unlocks a controller that is locked ($X) and
// has no switches; one that has is homed.

#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/grbl/grbl_line.h"
#include "services/drivers/grbl/marks/grbl_course_hand.h"
#include "services/drivers/grbl/marks/grbl_course_program.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/drivers/interface/seen_marks.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class GrblCourseDriver final : public MarkDriver {
 public:
  static constexpr double kAhead_s = 0.15;
  static constexpr std::size_t kQueuedMarks = 64;
  static constexpr std::chrono::milliseconds kPermission{250};
  static constexpr std::chrono::milliseconds kBraking{200};

  GrblCourseDriver(const MachineSpec& machine, link::StreamOpener open,
                   link::SteadyClock clock);

  void Poll() override;
  int fd() const override { return line_.fd(); }
  const MarkDeviceState& state() const override { return state_; }
  HandMotion* hand() override { return &hand_motion_; }
  std::vector<MarkEvent> TakeEvents() override;
  Status Permit(bool permitted) override;
  Status Hold() override;
  Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) override;
  std::size_t Room() const override;
  Status Append(const NumberedMark& mark) override;
  Status Finish() override;
  Status Pause() override;
  Status Stop() override;
  Status Reset() override;
  Status RequestPast(std::uint32_t run, std::uint32_t first,
                     std::uint32_t count) override;

 private:
  struct InFlight {
    double seconds = 0;
    int blocks = 0;
    bool waits = false;  ///< it is acknowledged when all before it was made
    bool ends_mark = false, ends_run = false;
    bool acknowledged = false;
  };
  enum class Hand { kNone, kAnnounced, kSending, kEnding };

  void Receive(const GrblLine::Event& event);
  void TakeUp();
  void TakeLost();
  void TakeOk();
  void TakeStatus(const GrblStatus& status);
  void TakeAlarm(const GrblAlarm& alarm);
  void TakeProgress();
  void EndMark(MarkFate fate);
  void EndRun();
  void Executed(int blocks);

  void CheckPermission();
  /// Whether the newest permission is not older than `lease`.
  bool is_permitted_for(std::chrono::milliseconds lease) const;
  bool may_feed() const { return !held_ && is_permitted_for(kPermission); }
  /// Beam or spindle may be on.
  bool may_be_on() const { return is_permitted_for(spindle() ? kMaxHold : kPermission); }
  void Feed();
  void FeedMark();
  bool Send(const CourseLine& line, InFlight kind);
  double AheadSeconds() const;

  void DropQueue();
  void BeginStop();
  void FeedStop();
  void EndStop();
  void FeedRecovery();
  /// A stop of the controller's own.
  void StopItself(std::string why);
  void Fault(std::string why);
  void EndFault();
  void AddEvent(std::uint32_t mark, MarkFate fate);
  void Report();
  void UpdateReach();
  std::string WhyPlaceIsLost() const;
  bool spindle() const { return options_.tool == GrblTool::kSpindle; }
  std::chrono::nanoseconds now() const { return clock_(); }

  link::SteadyClock clock_;
  CourseTool tool_;
  CourseToolOptions options_;
  GrblLine line_;
  GrblCourseProgram program_;
  GrblCourseHand hand_motion_;
  GrblStatus grbl_;
  MarkDeviceState state_;
  bool has_status_ = false;
  std::uint32_t power_ups_ = 0;  ///< of the line, to which state_.power_up belongs
  std::uint32_t own_stops_ = 0;
  std::vector<MarkEvent> events_;
  SeenMarks seen_;

  std::optional<std::uint32_t> run_;
  std::vector<mark::Pen> pens_;
  bool finishes_ = false;
  std::deque<NumberedMark> queue_;
  std::optional<NumberedMark> hand_;
  Hand stage_ = Hand::kNone;
  std::optional<CourseLine> pending_;
  std::deque<InFlight> in_flight_;
  bool turns_ = false;      ///< M3 was sent
  bool run_ends_ = false;   ///< M5 was sent behind its last mark
  bool unsettled_ = false;  ///< the line was lost: what the controller holds is made

  std::optional<std::chrono::nanoseconds> permit_at_;
  bool held_ = false;  ///< nothing is sent before the next permission
  bool stopping_ = false, stop_reset_ = false, recovers_ = false;
  std::chrono::nanoseconds stop_at_{0}, status_at_{0};
};

std::unique_ptr<MarkDriver> MakeGrblCourseDriver(const MachineSpec& machine,
                                                 link::StreamOpener open,
                                                 link::SteadyClock clock);

/// mark_line.device, course_tool.kind; spindle_rpm of a spindle, and none of a laser.
std::vector<Error> CheckGrblCourseProfile(const MachineSpec& machine);

}  // namespace intaglio::drivers
