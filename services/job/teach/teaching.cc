#include "services/job/teach/teaching.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "engrave/core/try.h"
#include "services/job/checks/taught_check.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

void Set(Vector3& to, const Vec3& from) {
  to.set_x(from.x());
  to.set_y(from.y());
  to.set_z(from.z());
}

/// `taught` in place of the machine's, when it is right.
Result<TaughtPositions> Checked(const MachineSpec& machine, TaughtPositions taught) {
  for (const Finding& finding : OutOfRange(taught, "taught")) {
    return tl::unexpected<Error>(finding);
  }
  MachineSpec changed = machine;
  *changed.mutable_taught() = taught;
  std::vector<Error> errors;
  CheckTaught(changed, errors);
  if (!errors.empty()) return tl::unexpected(errors.front());
  return taught;
}

Status CheckChannel(const MachineSpec& machine, std::uint32_t channel) {
  if (channel >= 1 && channel <= machine.laser().channels()) return {};
  return Fail(ErrorCode::kNotFound,
              fmt::format("channel {} is none of {}, which has 1 to {}", channel,
                          machine.name(), machine.laser().channels()),
              std::to_string(channel));
}

Result<TaughtPositions> WithOrigin(const MachineSpec& machine, const ZeroChoice& choice,
                                   const Vec3& origin_mm) {
  const std::string lens = INTAGLIO_TRY(TaughtLens(machine, choice.lens));
  INTAGLIO_TRY(CheckChannel(machine, choice.channel));
  Vec3 wanted_mm = BlockOriginOf(machine, choice.channel, lens);
  for (int i = 0; i < 3; ++i) {
    if (choice.sets[static_cast<std::size_t>(i)]) wanted_mm[i] = origin_mm[i];
  }
  TaughtPositions taught = machine.taught();
  TaughtZero* zero = nullptr;
  for (TaughtZero& known : *taught.mutable_zeros()) {
    if (known.channel() == choice.channel && known.lens() == lens) zero = &known;
  }
  if (zero == nullptr) zero = taught.add_zeros();
  zero->set_channel(choice.channel);
  zero->set_lens(lens);
  Set(*zero->mutable_block_origin_mm(), wanted_mm);
  return Checked(machine, std::move(taught));
}

}  // namespace

Result<std::string> TaughtLens(const MachineSpec& machine, const std::string& name) {
  if (name.empty() && machine.lenses_size() == 1) return machine.lenses(0).name();
  std::vector<std::string> names;
  for (const MachineLens& lens : machine.lenses()) {
    if (lens.name() == name) return name;
    names.push_back(lens.name());
  }
  if (name.empty()) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{} has several lenses: name the mounted one, of {}",
                            machine.name(), fmt::join(names, ", ")));
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("lens \"{}\" is not a lens of {}, which has {}", name,
                          machine.name(), fmt::join(names, ", ")),
              name);
}

Result<TaughtPositions> WithZero(const MachineSpec& machine, const Vec3& axes,
                                 const ZeroChoice& choice) {
  return WithOrigin(machine, choice,
                    KinematicsOf(machine)->ToPlace(axes) - choice.at_glass_mm);
}

Result<TaughtPositions> WithZeroMoved(const MachineSpec& machine, const Vec3& by_mm,
                                      const ZeroChoice& choice) {
  const std::string lens = INTAGLIO_TRY(TaughtLens(machine, choice.lens));
  return WithOrigin(machine, choice,
                    BlockOriginOf(machine, choice.channel, lens) + by_mm);
}

Result<Vec3> AxesAtZero(const MachineSpec& machine, const Vec3& axes,
                        const ZeroChoice& choice) {
  const std::string lens = INTAGLIO_TRY(TaughtLens(machine, choice.lens));
  INTAGLIO_TRY(CheckChannel(machine, choice.channel));
  const Vec3 corner_mm = BlockOriginOf(machine, choice.channel, lens);
  return KinematicsOf(machine)->ToAxes(corner_mm + choice.at_glass_mm, axes);
}

Result<TaughtPositions> WithSample(const MachineSpec& machine,
                                   const std::optional<Vec3>& axes) {
  TaughtPositions taught = machine.taught();
  taught.clear_sample();
  if (axes) Set(*taught.mutable_sample(), *axes);
  return Checked(machine, std::move(taught));
}

Result<TaughtPositions> WithPark(const MachineSpec& machine,
                                 const std::optional<Vec3>& axes) {
  TaughtPositions taught = machine.taught();
  taught.clear_park();
  if (axes) Set(*taught.mutable_park(), *axes);
  return Checked(machine, std::move(taught));
}

Result<TaughtPositions> WithSoftLimits(const MachineSpec& machine,
                                       const std::optional<Box3>& axes) {
  TaughtPositions taught = machine.taught();
  taught.clear_limits();
  if (axes) {
    Set(*taught.mutable_limits()->mutable_min(), axes->min_mm);
    Set(*taught.mutable_limits()->mutable_max(), axes->max_mm);
  }
  return Checked(machine, std::move(taught));
}

}  // namespace intaglio
