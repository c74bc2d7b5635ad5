#include "services/cell/manual/manual_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <vector>

#include "services/platform/bus/samples.h"

namespace intaglio::cell {
namespace {

using bus::Borrow;
using bus::View;
using namespace std::chrono_literals;

// As the synchronizer's: written every 20 ms.
constexpr auto kPermissionTime = 90ms;
constexpr auto kBusyPeriod = 20ms;
constexpr auto kIdlePeriod = 500ms;
constexpr auto kBusyTime = 5s;

Vec3 VectorOf(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

void Put(const Vec3& from, double (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

/// None where the sample has more of x than of y, or of y than of x.
std::vector<Vec2> CornersOf(const intaglio_ManualCommand& command) {
  const auto x = View(command.outline_x_mm), y = View(command.outline_y_mm);
  if (x.size() != y.size()) return {};
  std::vector<Vec2> corners;
  // One more than there may be is refused.
  for (std::size_t i = 0; i < std::min(x.size(), drivers::kMaxOutlineCorners + 1); ++i)
    corners.emplace_back(x[i], y[i]);
  return corners;
}

ManualOrder OrderOf(const intaglio_ManualCommand& command, bool by_cell) {
  return {std::string(View(command.sender)),
          command.number,
          command.seen,
          command.kind,
          VectorOf(command.place),
          command.speed_mm_s,
          by_cell,
          command.channel,
          command.sets,
          CornersOf(command)};
}

bool IsTeaching(intaglio_ManualCommandKind kind) {
  return kind >= intaglio_TEACH_ZERO && kind <= intaglio_TEACH_UNDO;
}

}  // namespace

ManualDesk::ManualDesk(bus::Bus& bus, const std::string& cell,
                       drivers::HandMotion& motion, Teacher& teacher)
    : cell_(cell),
      motion_(motion),
      teacher_(teacher),
      axes_(teacher.axes()),
      control_(motion, axes_.limits, axes_.names),
      commands_(bus, bus::kManualCommand, cell_),
      cell_moves_(bus, bus::kCellMove, cell_),
      interlocks_(bus, bus::kInterlock, cell_),
      permissions_(bus, bus::kPermission, cell_),
      states_(bus, bus::kManualState, cell_),
      // No state of another process is taken for one of this.
      number_(std::random_device{}() * 0x100000000ULL) {
  control_.SetChannels(teacher.channel_count());
}

void ManualDesk::TakeConditions(std::chrono::nanoseconds now) {
  permissions_.TakeAll(
      [&](const intaglio_Permission& sample, const bus::SampleOrigin& origin) {
        permission_at_ = origin.alive ? now : std::chrono::nanoseconds(-1);
        if (origin.alive) conditions_.job_armed = sample.granted;
      });
  interlocks_.TakeAll(
      [&](const intaglio_Interlock& sample, const bus::SampleOrigin& origin) {
        conditions_.interlocks_at = std::chrono::nanoseconds(-1);
        if (!origin.alive) return;
        conditions_.interlocks_at = now;
        conditions_.interlocks_age = std::chrono::milliseconds(sample.state_age_ms);
        conditions_.laser_line_up = sample.laser_link_up;
        conditions_.key_on = sample.key_on;
        conditions_.door_closed = sample.door_closed;
        conditions_.stop_released = sample.emergency_stop_released;
        conditions_.lamp_on = sample.lamp_on;
        conditions_.shutters_open = sample.shutters_open;
      });
  conditions_.permission_fresh =
      permission_at_.count() >= 0 && now - permission_at_ < kPermissionTime;
}

void ManualDesk::Turn(bool run_active, bool stop_pressed, std::chrono::nanoseconds now) {
  TakeConditions(now);
  conditions_.run_active = run_active;
  conditions_.stop_pressed = stop_pressed;
  TakeCommands(commands_, false, now);
  TakeCommands(cell_moves_, true, now);
  control_.Turn(conditions_, now);
  Publish(now);
}

void ManualDesk::TakeCommands(bus::Reader<intaglio_ManualCommand>& reader, bool by_cell,
                              std::chrono::nanoseconds now) {
  reader.TakeAll([&](const intaglio_ManualCommand& command,
                     const bus::SampleOrigin& origin) {
    if (!origin.alive) return control_.LoseSender(std::string(View(command.sender)));
    if (commanded_at_.count() < 0 || now - commanded_at_ > kBusyTime) next_state_ = now;
    commanded_at_ = now;
    const ManualOrder order = OrderOf(command, by_cell);
    const bool of_person =
        IsTeaching(command.kind) || command.kind == intaglio_MANUAL_LAMP ||
        command.kind == intaglio_MANUAL_ZERO || command.kind == intaglio_MANUAL_SHUTTER ||
        command.kind == intaglio_MANUAL_OUTLINE;
    if (by_cell && of_person) return;
    if (command.kind == intaglio_MANUAL_ZERO) return TakeAtZero(order, command, now);
    if (command.kind == intaglio_TEACH_ZERO && !teacher_.zero_is_in_controller() &&
        !motion_.state().place_lost.empty())
      return TakeAtZero(order, command, now);
    const bool executed =
        !IsTeaching(command.kind) ||
        (command.kind == intaglio_TEACH_ZERO && teacher_.zero_is_in_controller());
    if (executed) return control_.Receive(order, now);
    Teach(order, command, now);
  });
}

// The axes go to the zero, a motion by hand as any other, with its limits; or they are
// stated to be there.
void ManualDesk::TakeAtZero(ManualOrder order, const intaglio_ManualCommand& command,
                            std::chrono::nanoseconds now) {
  const auto axes = teacher_.AxesAtZero(command, motion_.state().position_mm);
  if (axes) {
    if (order.kind == intaglio_MANUAL_ZERO) order.kind = intaglio_MANUAL_MOVE;
    order.place = *axes;
    return control_.Receive(order, now);
  }
  if (control_.IsNew(order) && control_.IsFresh(order.seen, now) &&
      !control_.RefusesEarlier(order))
    control_.Answer(order, intaglio_MANUAL_REFUSED, axes.error().message);
}

std::string ManualDesk::WhyNoTeaching() const {
  if (conditions_.run_active) return "a job moves the stage: pause it first";
  if (!conditions_.permission_fresh)
    return "no job service answers for this machine: teaching needs its consent";
  if (conditions_.job_armed) return kJobIsArmed;
  if (!motion_.state().link_up)
    return "the stage does not answer: " + motion_.state().message;
  if (!motion_.state().at_rest) return "the stage moves: wait until it is at rest";
  if (!motion_.state().homed)
    return "the controller does not know where its axes are: home it first";
  if (!motion_.state().place_lost.empty()) return motion_.state().place_lost;
  return "";
}

void ManualDesk::Teach(const ManualOrder& order, const intaglio_ManualCommand& command,
                       std::chrono::nanoseconds now) {
  if (!control_.IsNew(order) || !control_.IsFresh(order.seen, now) ||
      control_.RefusesEarlier(order))
    return;
  std::string why = WhyNoTeaching();
  if (!why.empty())
    return control_.Answer(order, intaglio_MANUAL_REFUSED, std::move(why));
  const auto saved = teacher_.Save(command, motion_.state().position_mm);
  control_.Answer(order, saved ? intaglio_MANUAL_DONE : intaglio_MANUAL_REFUSED,
                  saved ? *saved : saved.error().message);
  axes_ = teacher_.axes();
  control_.SetLimits(axes_.limits);
}

void ManualDesk::Publish(std::chrono::nanoseconds now) {
  if (now < next_state_) return;
  const bool busy = commanded_at_.count() >= 0 && now - commanded_at_ < kBusyTime;
  next_state_ = now + (busy ? std::chrono::nanoseconds(kBusyPeriod)
                            : std::chrono::nanoseconds(kIdlePeriod));
  const drivers::DriverState& state = motion_.state();
  const std::string held_by = control_.held_by();
  const std::string refusal = WhyNoMotionByHand(conditions_, state, ManualOrder{}, now);
  const std::string names =
      fmt::format("{} {} {}", axes_.names[0], axes_.names[1], axes_.names[2]);
  intaglio_ManualState sample{};
  sample.cell = Borrow(cell_);
  sample.number = ++number_;
  sample.held_by = Borrow(held_by);
  sample.refusal = Borrow(refusal);
  sample.homed = state.homed;
  sample.axes = Borrow(names);
  sample.rotary = axes_.rotary;
  sample.lamp_by_hand = control_.lamp_by_hand();
  sample.shutters_by_hand = control_.shutters_by_hand();
  Put(state.position_mm, sample.position);
  Put(axes_.limits.min_mm, sample.limit_min);
  Put(axes_.limits.max_mm, sample.limit_max);
  sample.profile = Borrow(axes_.profile);
  sample.taught_number = axes_.taught_number;
  const ManualAnswer& answer = control_.answer();
  sample.answered_sender = Borrow(answer.sender);
  sample.answered_number = answer.number;
  sample.answer = answer.code;
  sample.message = Borrow(answer.message);
  sample.reports_missing = answer.reports_missing;
  control_.NotePublished(number_, now);
  (void)states_.Write(sample);
}

}  // namespace intaglio::cell
