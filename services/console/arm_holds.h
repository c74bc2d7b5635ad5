#pragma once

// Buttons that a person holds so that a machine may fire: the press begins a hold, and
// the arm or the resume ends it.
//
// clang-format off
//   begin   names the block that the person has read: it is the one that is mounted
//   end     once, kHoldTime to kHoldTime + kEndTime later, for the same job and the same block
// clang-format on
//
// No other request arms a job: a hold that was used, is late, or began in a console that
// has ended is not valid, so neither a reload, a reconnect nor a repeated message arms.
// The job service refuses a job that was paused or stopped meanwhile, by the disarm_count
// of the job as it was when the hold began.

#include <chrono>
#include <deque>
#include <string>

#include "engrave/core/result.h"
#include "services/client/shop/shop_snapshot.h"

namespace intaglio::console {

class ArmHolds {
 public:
  using Clock = std::chrono::steady_clock;
  /// Longer than a touch by mistake.
  static constexpr std::chrono::milliseconds kHoldTime{1200};
  /// For a slow network; a message that waited for longer arms nothing.
  static constexpr std::chrono::milliseconds kEndTime{2000};
  /// People who press at the same time; then the oldest hold is dropped.
  static constexpr std::size_t kMaxCount = 16;

  /// The token of a new hold; it replaces the one of the same job. `block`: ReportIn.
  std::string Begin(const client::JobView& job, const std::string& block,
                    Clock::time_point now);
  /// The job as it was when the hold began; the hold is used then, whatever the answer.
  /// kRefused: no such hold, of another job, too early, too late, or of another block.
  Result<client::JobView> End(const std::string& token, const std::string& uid,
                              const std::string& block, Clock::time_point now);
  /// Nothing that is held counts any more.
  void LetGo() { holds_.clear(); }

 private:
  struct Hold {
    std::string token;
    client::JobView job;
    std::string block;
    Clock::time_point begun;
  };
  std::deque<Hold> holds_;  // the oldest first
};

/// Why no hold begins at a machine.
struct Obstacle {
  std::string code;  ///< not_mounted, line_down, key_off, door_open, input_open,
                     ///< stop_pressed
  std::string message;
};
/// The first thing that is in the way of a job at this machine; an empty code: nothing.
/// What is not known is not taken for closed.
Obstacle ObstacleOf(const client::ShopSnapshot& shop, const std::string& cell);

/// Block, glass and lens, or the piece, as a person has reported them; empty: nobody did.
std::string BlockIn(const client::ShopSnapshot& shop, const std::string& cell);

/// The same, and when it was reported: a person who reports another piece may use the
/// same words.
std::string ReportIn(const client::ShopSnapshot& shop, const std::string& cell);

}  // namespace intaglio::console
