#pragma once

// What a person can do at a BJJCZ board that makes marks: have the guide laser draw an
// outline. Mirrors are where they are told to be, so nothing is homed, and no zero is
// set. bjjcz_driver.h has the line, and plays the lists.

#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/guide_outline.h"
#include "services/drivers/bjjcz/mark_lists.h"
#include "services/drivers/interface/hand_motion.h"
#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

/// Why a board that marks refuses, once the chain was opened.
inline constexpr char kChainWasOpened[] =
    "key, door or stop button was opened: close them, then reset";

class BjjczMarkHand final : public HandMotion {
 public:
  /// `lists` outlives this. `reset`: MarkDriver::Reset.
  BjjczMarkHand(const MachineSpec& machine, MarkLists& lists,
                std::function<Status()> reset)
      : board_(machine.bjjcz_board()), lists_(lists), reset_(std::move(reset)) {}

  const DriverState& state() const override { return state_; }
  Status ClearFault() override { return reset_(); }
  Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) override;
  Status Hold() override;

  /// Until the mirrors rest.
  bool active() const { return outline_.has_value(); }
  /// A person holds it.
  bool draws() const { return outline_ && !held_; }
  /// The mirrors are on the way of the outline.
  bool shows() const { return draws() && outline_->is_there(); }
  /// The next list of it; draws().
  LmcList Next() { return lists_.TakeGuide(*outline_); }
  void SetPlayed() { outline_->SetPlayed(); }
  void End() { outline_.reset(); }
  /// What the driver knows.
  void TakeState(const MarkDeviceState& mark);

 private:
  BjjczBoard board_;
  MarkLists& lists_;
  std::function<Status()> reset_;
  DriverState state_;
  std::optional<GuideOutline> outline_;
  bool held_ = false;  ///< it ends behind the list that the board has
};

}  // namespace intaglio::drivers
