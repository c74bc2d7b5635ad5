#include "services/console/teach/jog_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "services/platform/bus/manual_orders.h"

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kForgetLimits = "forget_limits";

std::optional<intaglio_ManualCommandKind> KindNamed(const std::string& name) {
  if (name.empty()) return intaglio_MANUAL_NONE;
  if (name == "jog") return intaglio_MANUAL_JOG;
  if (name == "move") return intaglio_MANUAL_MOVE;
  if (name == "home") return intaglio_MANUAL_HOME;
  if (name == "zero") return intaglio_MANUAL_ZERO;
  if (name == "lamp") return intaglio_MANUAL_LAMP;
  if (name == "shutter") return intaglio_MANUAL_SHUTTER;
  if (name == "save_zero") return intaglio_TEACH_ZERO;
  if (name == "move_zero") return intaglio_TEACH_ZERO_MOVED;
  if (name == "save_sample") return intaglio_TEACH_SAMPLE;
  if (name == "save_park") return intaglio_TEACH_PARK;
  if (name == "save_limits" || name == kForgetLimits) return intaglio_TEACH_LIMITS;
  if (name == "undo") return intaglio_TEACH_UNDO;
  return std::nullopt;
}

const char* NameOf(intaglio_ManualAnswer answer) {
  switch (answer) {
    case intaglio_MANUAL_ACCEPTED:
      return "accepted";
    case intaglio_MANUAL_DONE:
      return "done";
    case intaglio_MANUAL_STOPPED:
      return "stopped";
    case intaglio_MANUAL_REFUSED:
      return "refused";
  }
  return "";
}

/// What all pages see; the answer is of one of them.
JogView ViewOf(const client::MachineView& machine) {
  JogView view;
  view.set_cell(machine.cell);
  view.set_number(machine.number);
  view.set_held(!machine.held_by.empty());
  view.set_refusal(machine.refusal);
  view.set_homed(machine.homed);
  view.set_taught_number(machine.taught_number);
  view.set_lamp_by_hand(machine.lamp_by_hand);
  for (std::uint32_t channel = 1; channel <= 4; ++channel) {
    if ((machine.shutters_by_hand >> (channel - 1) & 1) != 0)
      view.add_shutters_by_hand(channel);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const std::string& name = machine.axes[static_cast<std::size_t>(axis)];
    if (name.empty()) break;
    JogAxis& shown = *view.add_axes();
    shown.set_name(name);
    shown.set_position(machine.position[axis]);
    shown.set_min(machine.limit_min[axis]);
    shown.set_max(machine.limit_max[axis]);
    shown.set_rotary(machine.rotary[static_cast<std::size_t>(axis)]);
  }
  return view;
}

}  // namespace

Result<bool> JogDesk::Pass(web::PeerId page, const JogRequest& request,
                           const std::string& person, Clock::time_point now) {
  const auto kind = KindNamed(request.kind());
  if (!kind) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format(
            "kind '{}': give jog, move, home, zero, lamp, shutter, save_zero, "
            "move_zero, save_sample, save_park, save_limits, forget_limits, undo, or "
            "nothing",
            request.kind()),
        request.kind());
  }
  bool is_first = false;
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    ForgetPages(now);
    Page& known = pages_[page];
    // A page that has not seen the machine yet cannot begin.
    is_first = *kind != intaglio_MANUAL_NONE && known.press != request.press() &&
               request.seen() != 0;
    if (is_first) {
      known.press = request.press();
      known.number = bus::NumberOfOrder(known.number, request.seen());
    }
    known.cell = request.cell();
    known.sent = now;
    number = known.number;
  }
  client::SentOrder sent;
  sent.cell = request.cell();
  sent.sender = relay_.SenderOf(page);
  sent.number = number;
  sent.seen = request.seen();
  sent.operator_name = person;
  sent.order.kind = *kind;
  sent.order.place = {request.x(), request.y(), request.z()};
  sent.order.place_max = {request.x_max(), request.y_max(), request.z_max()};
  sent.order.forget = request.kind() == kForgetLimits;
  sent.order.speed_mm_s = request.speed_mm_s();
  sent.order.channel = request.channel();
  sent.order.lens = request.lens();
  if (request.sets() != 0) sent.order.sets = static_cast<std::uint8_t>(request.sets());
  if (const auto passed = relay_.Pass(sent); !passed)
    return tl::unexpected(passed.error());
  return is_first;
}

// A page keeps the number of its press while it is silent, or the same press would begin
// again.
void JogDesk::ForgetPages(Clock::time_point now) {
  constexpr std::size_t kMaxPages = 1024;
  if (pages_.size() < kMaxPages) return;
  std::erase_if(pages_, [&](const auto& one) { return now - one.second.sent > 60s; });
}

bool JogDesk::IsAtWork(Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  return std::any_of(pages_.begin(), pages_.end(), [&](const auto& page) {
    return now - page.second.sent <= kQuietTime;
  });
}

Result<client::MachineView> JogDesk::Machine(const std::string& cell,
                                             Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  const auto known = machines_.find(cell);
  if (known != machines_.end() && now - known->second.taken <= kKnownTime)
    return known->second.view;
  return Fail(
      ErrorCode::kNotFound,
      fmt::format("{}: no such machine answers here: check that its motion bridge "
                  "runs (intaglio up)",
                  cell),
      cell);
}

std::vector<client::MachineView> JogDesk::Machines(Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  std::vector<client::MachineView> machines;
  for (const auto& [cell, known] : machines_)
    if (now - known.taken <= kKnownTime) machines.push_back(known.view);
  return machines;
}

std::vector<std::pair<web::PeerId, JogView>> JogDesk::TakeNew(Clock::time_point now) {
  std::vector<std::pair<web::PeerId, JogView>> views;
  for (client::MachineView& machine : relay_.TakeNew()) {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, page] : pages_) {
      if (page.cell != machine.cell || now - page.sent > kQuietTime) continue;
      JogView view = ViewOf(machine);
      view.set_held_here(machine.held_by == relay_.SenderOf(id));
      if (machine.answered_sender == relay_.SenderOf(id) &&
          machine.answered_number == page.number) {
        view.set_answered_press(page.press);
        view.set_answer(NameOf(machine.answer));
        view.set_message(machine.message);
      }
      views.emplace_back(id, std::move(view));
    }
    Known& known = machines_[machine.cell];
    known = {std::move(machine), now};
  }
  return views;
}

}  // namespace intaglio::console
