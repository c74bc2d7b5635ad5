#pragma once

// Motion by hand of a mill or a laser that follows contours, and its work zero
// (grbl_course_driver.h has the line, and gives this its answers while it is active).
//
//   Jog      M5S0, then $J= in pieces of 50 ms, never more than kAhead_s ahead; one that
//            the controller cuts (grbl_jog.h) is a stop of its own
//   Hold     0x85 until nothing moves
//   Home     M5S0, $H; Hold: 0x18
//   SetZero  M5S0, G10L20P1 X Y Z: the place of the tool gets these coordinates in G54,
//            which the controller keeps when it is off
//
// Beam and spindle are off before anything moves. A line that is lost leaves kAhead_s of
// motion, without a beam or a spindle. What ended, for whatever reason, does not go on.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "services/drivers/grbl/grbl_jog.h"
#include "services/drivers/grbl/grbl_line.h"
#include "services/drivers/interface/hand_motion.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class GrblCourseHand final : public HandMotion {
 public:
  static constexpr double kAhead_s = 0.15;
  static constexpr double kPiece_s = 0.05;

  /// `line` outlives this. `reset`: brings the controller out of a fault. `stopped`: the
  /// controller has stopped by itself; it calls End.
  GrblCourseHand(GrblLine& line, link::SteadyClock clock, std::function<Status()> reset,
                 std::function<void(std::string)> stopped)
      : line_(line),
        clock_(std::move(clock)),
        reset_(std::move(reset)),
        stopped_(std::move(stopped)) {}

  const DriverState& state() const override { return state_; }
  Status ClearFault() override;
  Status Jog(const Vec3& axes_mm, double speed_mm_s) override;
  Status Home() override;
  Status SetZero(const Vec3& here_mm, const std::array<bool, 3>& sets) override;
  Status Hold() override;

  /// Something is under way: the answers of the line are for this.
  bool active() const { return what_ != What::kNone; }
  /// All places where what is under way may leave the tool, as the controller counts.
  Box3 reach() const;
  void Receive(const GrblLine::Event& event);
  /// What the driver knows; `runs`: it has marks to make.
  void TakeState(const MarkDeviceState& mark, const GrblStatus& status, bool runs);
  void Feed();
  /// The line was lost or reset, or the driver has a fault.
  void End();

 private:
  enum class What { kNone, kJog, kHome, kZero };
  struct Sent {
    double seconds = 0;
    int blocks = 0;
    bool acknowledged = false;
  };

  Status Begin(What what);
  void TakeStatus(const GrblStatus& status);
  void WatchJog(const GrblStatus& status);
  bool SendDark();
  void FeedJog();
  void FeedZero();
  void Sends(double seconds, int blocks);
  double AheadSeconds() const;

  GrblLine& line_;
  link::SteadyClock clock_;
  std::function<Status()> reset_;
  std::function<void(std::string)> stopped_;
  DriverState state_;
  GrblState grbl_ = GrblState::kOther;

  What what_ = What::kNone;
  std::deque<Sent> sent_;
  bool dark_ = false, cancelled_ = false, all_sent_ = false;
  bool placed_ = false;  ///< from_mm_ is where it rests
  bool homed_ = false;
  bool status_is_behind_ = false;       ///< the newest status came behind the last answer
  std::optional<std::string> refused_;  ///< what the controller refused a line for
  GrblJogMoves moves_;
  Vec3 from_mm_ = Vec3::Zero(), to_mm_ = Vec3::Zero();
  double sent_mm_ = 0, speed_mm_s_ = 0;
  std::array<bool, 3> sets_{};
};

}  // namespace intaglio::drivers
