#include "services/job/checks/taught_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "services/job/fields/channels.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

template <typename Value>
void Wrong(std::vector<Error>& errors, const std::string& path, const Value& value,
           const std::string& what) {
  const std::string text = fmt::format("{}", value);
  errors.push_back(
      {ErrorCode::kInvalidValue, fmt::format("{}: {} {}", path, text, what), text});
}

bool HasLens(const MachineSpec& machine, const std::string& name) {
  const auto& lenses = machine.lenses();
  return std::any_of(lenses.begin(), lenses.end(),
                     [&](const MachineLens& lens) { return lens.name() == name; });
}

void CheckZerosOf(const MachineSpec& machine, std::vector<Error>& errors) {
  std::set<std::pair<std::uint32_t, std::string>> seen;
  for (int i = 0; i < machine.taught().zeros_size(); ++i) {
    const TaughtZero& zero = machine.taught().zeros(i);
    const std::string path = fmt::format("taught.zeros[{}]", i);
    if (zero.channel() > machine.laser().channels()) {
      Wrong(errors, path + ".channel", zero.channel(),
            fmt::format("is above laser.channels, {}", machine.laser().channels()));
    }
    if (!HasLens(machine, zero.lens())) {
      Wrong(errors, path + ".lens", zero.lens(), "is no name of one of the lenses");
    }
    if (!zero.has_block_origin_mm()) {
      Wrong(errors, path + ".block_origin_mm", "", "is missing; give the place");
    }
    if (!seen.insert({zero.channel(), zero.lens()}).second) {
      Wrong(errors, path, zero.lens(),
            fmt::format("has a zero in channel {} already", zero.channel()));
    }
  }
}

void CheckSoftLimits(const MachineSpec& machine, std::vector<Error>& errors) {
  if (!machine.taught().has_limits()) return;
  MachineSpec bare = machine;
  bare.clear_taught();
  const Box3 travel = AxisLimitsOf(bare).travel_mm;
  const Vec3 min = Vec3Of(machine.taught().limits().min());
  const Vec3 max = Vec3Of(machine.taught().limits().max());
  const auto axes = KinematicsOf(machine)->axes();
  for (int i = 0; i < 3; ++i) {
    const auto name = axes[static_cast<std::size_t>(i)].name;
    if (min[i] < max[i] && min[i] >= travel.min_mm[i] && max[i] <= travel.max_mm[i])
      continue;
    if (!(min[i] < max[i])) {
      Wrong(errors, fmt::format("taught.limits, axis {}", name),
            fmt::format("{} to {}", min[i], max[i]),
            "has its smallest place not below its largest: exchange them");
      continue;
    }
    Wrong(errors, fmt::format("taught.limits, axis {}", name),
          fmt::format("{} to {}", min[i], max[i]),
          fmt::format("is not within the axis' travel, {} to {}", travel.min_mm[i],
                      travel.max_mm[i]));
  }
}

void CheckPlace(const MachineSpec& machine, bool taught, const Vector3& place,
                const char* field, std::vector<Error>& errors) {
  if (!taught) return;
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const Vec3 at = Vec3Of(place);
  const auto axes = KinematicsOf(machine)->axes();
  for (int i = 0; i < 3; ++i) {
    if (at[i] >= travel.min_mm[i] && at[i] <= travel.max_mm[i]) continue;
    Wrong(
        errors,
        fmt::format("taught.{}, axis {}", field, axes[static_cast<std::size_t>(i)].name),
        at[i],
        fmt::format("is outside the limits, {} to {}: teach it again", travel.min_mm[i],
                    travel.max_mm[i]));
  }
}

}  // namespace

void CheckTaught(const MachineSpec& machine, std::vector<Error>& errors) {
  if (!machine.has_taught()) return;
  const TaughtPositions& taught = machine.taught();
  CheckZerosOf(machine, errors);
  CheckSoftLimits(machine, errors);
  CheckPlace(machine, taught.has_sample(), taught.sample(), "sample", errors);
  CheckPlace(machine, taught.has_park(), taught.park(), "park", errors);
}

void CheckZeros(const JobSpec& job, const MachineSpec& machine, Findings& findings) {
  const double allowed_mm = 1e-3 * machine.position_tolerance_um();
  for (int i = 0; i < job.models_size(); ++i) {
    const auto& own = job.models(i).channels();
    const auto& channels = own.empty() ? job.laser().channels() : own;
    if (channels.empty()) continue;
    const Vec3 first_mm = BlockOriginOf(machine, job, channels[0]);
    for (const std::uint32_t channel : channels) {
      const double apart_mm = (BlockOriginOf(machine, job, channel) - first_mm).norm();
      if (apart_mm <= allowed_mm) continue;
      findings.Wrong(fmt::format("models[{}].channels", i), channel,
                     "has a zero that is {:.4g} mm from that of channel {}: one position "
                     "of the stage cannot serve both; engrave them in jobs of their own, "
                     "or teach their zeros or correct channel_positions",
                     apart_mm, channels[0]);
      break;
    }
  }
}

}  // namespace intaglio
