#include "services/motion_bridge/profile_teacher.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>

#include "engrave/core/try.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/teach/profile_history.h"
#include "services/job/teach/teaching.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::motion_bridge {
namespace {

using bus::View;

Vec3 PlaceOf(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

ZeroChoice ChoiceOf(const intaglio_ManualCommand& command) {
  ZeroChoice choice;
  choice.channel = command.channel;
  choice.lens = View(command.lens);
  choice.at_glass_mm = PlaceOf(command.place);
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
                         command.channel, lens, PlaceText(PlaceOf(command.place)));
    case intaglio_TEACH_ZERO_MOVED:
      return fmt::format("zero of channel {}, lens {}, moved by {} mm", command.channel,
                         lens, PlaceText(PlaceOf(command.place)));
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

Result<TaughtPositions> ChangedBy(const intaglio_ManualCommand& command,
                                  const MachineSpec& machine, const Vec3& axes) {
  const auto here = command.forget ? std::nullopt : std::optional<Vec3>(axes);
  switch (command.kind) {
    case intaglio_TEACH_ZERO:
      return WithZero(machine, axes, ChoiceOf(command));
    case intaglio_TEACH_ZERO_MOVED:
      return WithZeroMoved(machine, PlaceOf(command.place), ChoiceOf(command));
    case intaglio_TEACH_SAMPLE:
      return WithSample(machine, here);
    case intaglio_TEACH_PARK:
      return WithPark(machine, here);
    case intaglio_TEACH_LIMITS:
      if (command.forget) return WithSoftLimits(machine, std::nullopt);
      return WithSoftLimits(machine,
                            Box3{PlaceOf(command.place), PlaceOf(command.place_max)});
    default:
      return Fail(ErrorCode::kUnsupported, "this machine does not know the command");
  }
}

}  // namespace

cell::TaughtAxes ProfileTeacher::axes() const {
  cell::TaughtAxes taught;
  const auto axes = KinematicsOf(machine_)->axes();
  for (std::size_t i = 0; i < 3; ++i) {
    taught.names[i] = axes[i].name;
    if (axes[i].unit == machine::AxisUnit::kRad)
      taught.rotary = static_cast<std::uint8_t>(taught.rotary | 1u << i);
  }
  taught.limits = AxisLimitsOf(machine_).travel_mm;
  taught.profile = std::filesystem::absolute(profile_).string();
  taught.taught_number = machine_.taught().number();
  return taught;
}

Result<Vec3> ProfileTeacher::AxesAtZero(const intaglio_ManualCommand& command,
                                        const Vec3& position) const {
  return intaglio::AxesAtZero(machine_, position, ChoiceOf(command));
}

Result<std::string> ProfileTeacher::Save(const intaglio_ManualCommand& command,
                                         const Vec3& position) {
  auto saved = Change(command, position);
  if (const auto machine = ReadMachineFile(profile_))
    *machine_.mutable_taught() = machine->taught();
  return saved;
}

Result<std::string> ProfileTeacher::Change(const intaglio_ManualCommand& command,
                                           const Vec3& position) const {
  TaughtNote note{host::UtcText(std::chrono::system_clock::now()),
                  std::string(View(command.operator_name)), TextOf(command)};
  if (command.kind == intaglio_TEACH_UNDO) {
    const auto undone = INTAGLIO_TRY(UndoTaught(profile_, note));
    host::LogInfo("taught by {}: {}", note.taught_by, undone.change());
    return fmt::format("version {}: {}", undone.taught().number(), undone.change());
  }
  const auto machine = INTAGLIO_TRY(ReadMachineFile(profile_));
  auto taught = INTAGLIO_TRY(ChangedBy(command, machine, position));
  const std::uint32_t number =
      INTAGLIO_TRY(SaveTaught(profile_, std::move(taught), note));
  host::LogInfo("taught by {}: {}", note.taught_by, note.change);
  return fmt::format("version {}: {}", number, note.change);
}

}  // namespace intaglio::motion_bridge
