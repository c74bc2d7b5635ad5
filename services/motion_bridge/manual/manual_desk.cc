#include "services/motion_bridge/manual/manual_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "engrave/core/try.h"
#include "services/job/job_file.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/teach/profile_history.h"
#include "services/job/teach/teaching.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::motion_bridge {
namespace {

using bus::Borrow;
using bus::View;
using namespace std::chrono_literals;

// As the synchronizer's: written every 20 ms.
constexpr auto kPermissionTime = 90ms;
// Written every 100 ms.
constexpr auto kInterlockTime = 500ms;
constexpr auto kBusyPeriod = 20ms;
constexpr auto kIdlePeriod = 500ms;
constexpr auto kBusyTime = 5s;

std::array<std::string, 3> NamesOf(const MachineSpec& machine) {
  std::array<std::string, 3> names;
  const auto axes = KinematicsOf(machine)->axes();
  for (std::size_t i = 0; i < 3; ++i) names[i] = axes[i].name;
  return names;
}

Vec3 VectorOf(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

void Put(const Vec3& from, double (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

ManualOrder OrderOf(const intaglio_ManualCommand& command, bool by_cell) {
  return {std::string(View(command.sender)),
          command.number,
          command.seen,
          command.kind,
          VectorOf(command.place),
          command.speed_mm_s,
          by_cell,
          command.channel};
}

ZeroChoice ChoiceOf(const intaglio_ManualCommand& command) {
  ZeroChoice choice;
  choice.channel = command.channel;
  choice.lens = View(command.lens);
  choice.at_glass_mm = VectorOf(command.place);
  for (std::size_t i = 0; i < 3; ++i) choice.sets[i] = (command.sets >> i & 1) != 0;
  return choice;
}

std::string PlaceText(const Vec3& place) {
  return fmt::format("{:.6g}, {:.6g}, {:.6g}", place.x(), place.y(), place.z());
}

std::string TextOf(const intaglio_ManualCommand& command) {
  const std::string lens(View(command.lens));
  switch (command.kind) {
    case intaglio_TEACH_ZERO:
      return fmt::format("zero of channel {}, lens {}, at {} of the block",
                         command.channel, lens, PlaceText(VectorOf(command.place)));
    case intaglio_TEACH_ZERO_MOVED:
      return fmt::format("zero of channel {}, lens {}, moved by {} mm", command.channel,
                         lens, PlaceText(VectorOf(command.place)));
    case intaglio_TEACH_SAMPLE:
      return command.forget ? "no sample position" : "sample position";
    case intaglio_TEACH_PARK:
      return command.forget ? "no park position" : "park position";
    case intaglio_TEACH_LIMITS:
      return command.forget ? "no soft limits" : "soft limits";
    default:
      return "";
  }
}

bool IsTeaching(intaglio_ManualCommandKind kind) {
  return kind >= intaglio_TEACH_ZERO && kind <= intaglio_TEACH_UNDO;
}

Result<TaughtPositions> ChangedBy(const intaglio_ManualCommand& command,
                                  const MachineSpec& machine, const Vec3& axes) {
  const auto here = command.forget ? std::nullopt : std::optional<Vec3>(axes);
  switch (command.kind) {
    case intaglio_TEACH_ZERO:
      return WithZero(machine, axes, ChoiceOf(command));
    case intaglio_TEACH_ZERO_MOVED:
      return WithZeroMoved(machine, VectorOf(command.place), ChoiceOf(command));
    case intaglio_TEACH_SAMPLE:
      return WithSample(machine, here);
    case intaglio_TEACH_PARK:
      return WithPark(machine, here);
    case intaglio_TEACH_LIMITS:
      if (command.forget) return WithSoftLimits(machine, std::nullopt);
      return WithSoftLimits(machine,
                            Box3{VectorOf(command.place), VectorOf(command.place_max)});
    default:
      return Fail(ErrorCode::kUnsupported, "this bridge does not know the command");
  }
}

}  // namespace

ManualDesk::ManualDesk(bus::Bus& bus, const MachineSpec& machine,
                       std::filesystem::path profile, drivers::MotionDriver& driver)
    : cell_(machine.name()),
      profile_(std::move(profile)),
      machine_(machine),
      driver_(driver),
      control_(driver, AxisLimitsOf(machine).travel_mm, NamesOf(machine)),
      commands_(bus, bus::kManualCommand, cell_),
      cell_moves_(bus, bus::kCellMove, cell_),
      interlocks_(bus, bus::kInterlock, cell_),
      permissions_(bus, bus::kPermission, cell_),
      states_(bus, bus::kManualState, cell_),
      // No state of another process is taken for one of this.
      number_(std::random_device{}() * 0x100000000ULL) {
  control_.SetChannels(machine.laser().channels());
}

void ManualDesk::TakeConditions(std::chrono::nanoseconds now) {
  permissions_.TakeAll(
      [&](const intaglio_Permission& sample, const bus::SampleOrigin& origin) {
        permission_at_ = origin.alive ? now : std::chrono::nanoseconds(-1);
        if (origin.alive) conditions_.job_armed = sample.granted;
      });
  interlocks_.TakeAll(
      [&](const intaglio_Interlock& sample, const bus::SampleOrigin& origin) {
        interlock_at_ = origin.alive ? now : std::chrono::nanoseconds(-1);
        if (!origin.alive) return;
        conditions_.laser_line_up = sample.laser_link_up;
        conditions_.key_on = sample.key_on;
        conditions_.door_closed = sample.door_closed;
        conditions_.stop_released = sample.emergency_stop_released;
        conditions_.lamp_on = sample.lamp_on;
        conditions_.shutters_open = sample.shutters_open;
      });
  conditions_.permission_fresh =
      permission_at_.count() >= 0 && now - permission_at_ < kPermissionTime;
  conditions_.interlocks_fresh =
      interlock_at_.count() >= 0 && now - interlock_at_ < kInterlockTime;
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
        command.kind == intaglio_MANUAL_ZERO || command.kind == intaglio_MANUAL_SHUTTER;
    if (by_cell && of_person) return;
    if (command.kind == intaglio_MANUAL_ZERO) return GoToZero(order, command, now);
    if (!IsTeaching(command.kind)) return control_.Take(order, now);
    Teach(order, command, now);
  });
}

// A motion to a place by hand as any other, with its limits.
void ManualDesk::GoToZero(ManualOrder order, const intaglio_ManualCommand& command,
                          std::chrono::nanoseconds now) {
  const auto axes = AxesAtZero(machine_, driver_.state().position_mm, ChoiceOf(command));
  if (axes) {
    order.kind = intaglio_MANUAL_MOVE;
    order.place = *axes;
    return control_.Take(order, now);
  }
  if (control_.IsNew(order) && control_.IsFresh(order.seen, now))
    control_.Answer(order, intaglio_MANUAL_REFUSED, axes.error().message);
}

std::string ManualDesk::WhyNoTeaching() const {
  if (conditions_.run_active) return "a job moves the stage: pause it first";
  if (!conditions_.permission_fresh)
    return "no job service answers for this machine: teaching needs its consent";
  if (conditions_.job_armed)
    return "a job is armed on this machine: pause or cancel it first";
  if (!driver_.state().link_up)
    return "the stage does not answer: " + driver_.state().message;
  if (!driver_.state().at_rest) return "the stage moves: wait until it is at rest";
  if (!driver_.state().homed)
    return "the controller does not know where its axes are: home it first";
  return "";
}

void ManualDesk::Teach(const ManualOrder& order, const intaglio_ManualCommand& command,
                       std::chrono::nanoseconds now) {
  if (!control_.IsNew(order) || !control_.IsFresh(order.seen, now)) return;
  std::string why = WhyNoTeaching();
  if (!why.empty())
    return control_.Answer(order, intaglio_MANUAL_REFUSED, std::move(why));
  const auto saved = Save(command);
  control_.Answer(order, saved ? intaglio_MANUAL_DONE : intaglio_MANUAL_REFUSED,
                  saved ? *saved : saved.error().message);
  ReadProfile();
}

Result<std::string> ManualDesk::Save(const intaglio_ManualCommand& command) {
  TaughtNote note{host::UtcText(std::chrono::system_clock::now()),
                  std::string(View(command.operator_name)), TextOf(command)};
  if (command.kind == intaglio_TEACH_UNDO) {
    const auto undone = INTAGLIO_TRY(UndoTaught(profile_, note));
    host::LogInfo("taught by {}: {}", note.taught_by, undone.change());
    return fmt::format("version {}: {}", undone.taught().number(), undone.change());
  }
  const auto machine = INTAGLIO_TRY(ReadMachineFile(profile_));
  auto taught = INTAGLIO_TRY(ChangedBy(command, machine, driver_.state().position_mm));
  const std::uint32_t number =
      INTAGLIO_TRY(SaveTaught(profile_, std::move(taught), note));
  host::LogInfo("taught by {}: {}", note.taught_by, note.change);
  return fmt::format("version {}: {}", number, note.change);
}

void ManualDesk::ReadProfile() {
  const auto machine = ReadMachineFile(profile_);
  if (!machine) return;
  *machine_.mutable_taught() = machine->taught();
  control_.SetLimits(AxisLimitsOf(machine_).travel_mm);
}

void ManualDesk::Publish(std::chrono::nanoseconds now) {
  if (now < next_state_) return;
  const bool busy = commanded_at_.count() >= 0 && now - commanded_at_ < kBusyTime;
  next_state_ = now + (busy ? std::chrono::nanoseconds(kBusyPeriod)
                            : std::chrono::nanoseconds(kIdlePeriod));
  const drivers::DriverState& state = driver_.state();
  const auto axes = KinematicsOf(machine_)->axes();
  const Box3 limits = AxisLimitsOf(machine_).travel_mm;
  const std::string held_by = control_.held_by();
  const std::string refusal = WhyNoMotionByHand(conditions_, state, false);
  const std::string names =
      fmt::format("{} {} {}", axes[0].name, axes[1].name, axes[2].name);
  intaglio_ManualState sample{};
  sample.cell = Borrow(cell_);
  sample.number = ++number_;
  sample.held_by = Borrow(held_by);
  sample.refusal = Borrow(refusal);
  sample.homed = state.homed;
  sample.axes = Borrow(names);
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes[i].unit == machine::AxisUnit::kRad)
      sample.rotary = static_cast<std::uint8_t>(sample.rotary | 1u << i);
  }
  sample.lamp_by_hand = control_.lamp_by_hand();
  sample.shutters_by_hand = control_.shutters_by_hand();
  Put(state.position_mm, sample.position);
  Put(limits.min_mm, sample.limit_min);
  Put(limits.max_mm, sample.limit_max);
  const std::string profile = std::filesystem::absolute(profile_).string();
  sample.profile = Borrow(profile);
  sample.taught_number = machine_.taught().number();
  const ManualAnswer& answer = control_.answer();
  sample.answered_sender = Borrow(answer.sender);
  sample.answered_number = answer.number;
  sample.answer = answer.code;
  sample.message = Borrow(answer.message);
  control_.NotePublished(number_, now);
  (void)states_.Write(sample);
}

}  // namespace intaglio::motion_bridge
