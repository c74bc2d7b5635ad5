#pragma once

// A controller of marks in memory, by the guarantees of
// services/drivers/interface/mark_driver.h, with its own record of what was made: it
// makes one mark at each Step.

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "services/drivers/interface/mark_driver.h"

namespace intaglio::marker {

using drivers::MarkFate;

class FakeHead final : public drivers::MarkDriver {
 public:
  FakeHead() {
    state_.link_up = state_.key_on = state_.door_closed = state_.stop_released = true;
    state_.session = 1;
    state_.power_up = "head-1";
    state_.remembers_marks = true;
  }

  void Poll() override {}
  int fd() const override { return -1; }
  const drivers::MarkDeviceState& state() const override { return state_; }
  std::vector<drivers::MarkEvent> TakeEvents() override {
    if (state_.link_up && !silent) ++state_.number;
    return std::exchange(events_, {});
  }
  Status Permit(bool permitted) override {
    if (!state_.link_up) return Down();
    permitted_ = permitted;
    held_ = held_ && !permitted;
    state_.shutter_open = permitted && opens_shutter;
    if (!permitted) Break("");
    return {};
  }
  Status Hold() override {
    if (!state_.can_hold) return MarkDriver::Hold();
    held_ = true;
    return {};
  }
  Status UseEye(const std::optional<drivers::PrintEye>& used) override {
    eye = used;
    return {};
  }
  Status Begin(std::uint32_t run, std::span<const mark::Pen>) override {
    if (!state_.link_up) return Down();
    if (active_ || run <= run_) return Fail(ErrorCode::kRefused, "run number");
    run_ = state_.newest_run = run;
    active_ = true;
    finishing_ = pausing_ = false;
    Update();
    return {};
  }
  std::size_t Room() const override {
    return active_ ? room - std::min(room, queue_.size()) : 0;
  }
  Status Append(const drivers::NumberedMark& mark) override {
    if (!active_) return Fail(ErrorCode::kRefused, "no run");
    handed.push_back(mark.number);
    queue_.push_back(mark.number);
    return {};
  }
  Status Finish() override {
    finishing_ = true;
    return {};
  }
  Status Pause() override {
    pausing_ = true;
    return {};
  }
  Status Stop() override {
    if (!state_.link_up) return Down();
    ++stops;
    Break("");
    return {};
  }
  Status Reset() override {
    ++resets;
    state_.fault.clear();
    state_.safe_state = false;
    return {};
  }
  Status RequestPast(std::uint32_t run, std::uint32_t first,
                     std::uint32_t count) override {
    ++questions;
    if (mute) return {};
    for (std::uint32_t mark = first; mark < first + count; ++mark) {
      const auto known = memory_.find({run, mark});
      events_.push_back({run, mark,
                         known != memory_.end()  ? known->second
                         : run == forgets_of_run ? MarkFate::kUncertain
                                                 : MarkFate::kNotBegun});
    }
    return {};
  }

  /// The mark in hand ends, or the next one begins.
  void Step() {
    if (!state_.link_up && !runs_on_without_host) return;
    if (!active_ || !permitted_ || held_) return;
    if (in_hand_) {
      made[*in_hand_]++;
      Note(*in_hand_, MarkFate::kDone);
      in_hand_.reset();
    } else if (!queue_.empty() && !pausing_) {
      in_hand_ = queue_.front();
      queue_.pop_front();
      if (without_print.contains(*in_hand_)) {
        Note(*in_hand_, MarkFate::kBegun);
        Note(*in_hand_, MarkFate::kNoPrintMark);
        return in_hand_.reset();
      }
      begun[*in_hand_]++;
      Note(*in_hand_, MarkFate::kBegun);
    }
    if (!in_hand_ && (pausing_ || (finishing_ && queue_.empty()))) EndRun();
    Update();
  }
  bool at_work() const { return in_hand_.has_value(); }
  bool held() const { return held_; }
  /// The beam ends by the controller's own means.
  void Break(const std::string& fault) {
    if (in_hand_) Note(*in_hand_, MarkFate::kBroken);
    in_hand_.reset();
    EndRun();
    if (!fault.empty()) state_.fault = fault;
    Update();
  }
  void LoseLine() {
    state_.link_up = false;
    events_.clear();
    Break("");
    events_.clear();
    state_.shutter_open = permitted_ = false;
  }
  void RestoreLine() {
    state_.link_up = true;
    ++state_.session;
  }
  /// A marker that died: the line and what it had been sent, and no more.
  void LoseHost() {
    LoseLine();
    RestoreLine();
  }
  void PowerCycle() {
    LoseLine();
    memory_.clear();
    run_ = state_.newest_run = 0;
    state_.power_up += "'";
    state_.openings = 0;
    RestoreLine();
  }

  std::size_t room = 4;
  std::uint32_t forgets_of_run = 0;
  bool opens_shutter = true, silent = false, mute = false, runs_on_without_host = false;
  std::optional<drivers::PrintEye> eye;
  std::set<std::uint32_t> without_print;
  std::vector<std::uint32_t> handed;
  std::map<std::uint32_t, int> made, begun;
  int stops = 0, resets = 0, questions = 0;
  drivers::MarkDeviceState state_;

 private:
  static tl::unexpected<Error> Down() { return Fail(ErrorCode::kLinkLost, "line down"); }
  void Note(std::uint32_t mark, MarkFate fate) {
    memory_[{run_, mark}] = fate;
    events_.push_back({run_, mark, fate});
  }
  void EndRun() {
    for (const std::uint32_t mark : std::exchange(queue_, {}))
      Note(mark, MarkFate::kNotBegun);
    active_ = finishing_ = pausing_ = held_ = false;
  }
  void Update() { state_.at_rest = state_.settled = !active_; }

  std::vector<drivers::MarkEvent> events_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, MarkFate> memory_;
  std::deque<std::uint32_t> queue_;
  std::optional<std::uint32_t> in_hand_;
  std::uint32_t run_ = 0;
  bool active_ = false, finishing_ = false, pausing_ = false, permitted_ = false,
       held_ = false;
};

}  // namespace intaglio::marker
