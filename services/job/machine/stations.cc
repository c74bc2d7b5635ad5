#include "services/job/machine/stations.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "services/job/fields/shapes.h"
#include "services/job/machine/block_origin.h"

// Two blocks that stand upright overlap when their outlines from above and their heights
// do. Two rectangles are apart exactly when a line along a side of one of them separates
// their corners.

namespace intaglio {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
// A block may touch its neighbour: rounding of turned corners.
constexpr double kTouchMm = 1e-6;

/// A block from above, in the machine frame, and its height.
struct Outline {
  std::array<Vec2, 4> corners_mm;
  double bottom_mm = 0, top_mm = 0;
};

Outline OutlineOf(const Vec3& origin_mm, const Vec3& size_mm, const StationPlace& place) {
  const Vec3 from = origin_mm + place.offset_mm, to = from + size_mm;
  const Eigen::Rotation2Dd turn(place.turn_rad);
  return {{turn * Vec2(from.x(), from.y()), turn * Vec2(to.x(), from.y()),
           turn * Vec2(to.x(), to.y()), turn * Vec2(from.x(), to.y())},
          from.z(),
          to.z()};
}

bool AreApartAlong(const Vec2& direction, const Outline& a, const Outline& b) {
  const auto span = [&](const Outline& outline) {
    std::array<double, 4> along;
    std::ranges::transform(outline.corners_mm, along.begin(),
                           [&](const Vec2& corner) { return corner.dot(direction); });
    const auto [min, max] = std::ranges::minmax_element(along);
    return std::pair(*min, *max);
  };
  const auto [a_min, a_max] = span(a);
  const auto [b_min, b_max] = span(b);
  return a_max <= b_min + kTouchMm || b_max <= a_min + kTouchMm;
}

bool Overlap(const Outline& a, const Outline& b) {
  if (a.top_mm <= b.bottom_mm + kTouchMm || b.top_mm <= a.bottom_mm + kTouchMm)
    return false;
  for (const Outline& outline : {a, b}) {
    for (const int side : {1, 3}) {
      const auto corner = static_cast<std::size_t>(side);
      const Vec2 direction =
          (outline.corners_mm[corner] - outline.corners_mm[0]).normalized();
      if (AreApartAlong(direction, a, b)) return false;
    }
  }
  return true;
}

void LoadingError(std::vector<Error>& errors, ErrorCode code, const std::string& text) {
  errors.push_back({code, "loading" + text, ""});
}

void CheckByCount(const MachineSpec& machine, std::vector<Error>& errors) {
  const Loading& loading = machine.loading();
  if (!loading.has_station_count()) {
    LoadingError(errors, ErrorCode::kMissing,
                 ".station_count: is missing; give how many blocks the table takes");
  }
  if (!machine.has_polar()) {
    const Vector3& pitch = loading.pitch_mm();
    if (pitch.x() == 0 && pitch.y() == 0 && pitch.z() == 0) {
      LoadingError(errors, ErrorCode::kMissing,
                   ".pitch_mm: is missing or 0; give how far a block's corner lies "
                   "from that of the station before");
    }
    return;
  }
  const double turns_rad = loading.station_count() * std::abs(loading.turn_rad());
  if (loading.turn_rad() == 0) {
    LoadingError(errors, ErrorCode::kMissing,
                 ".turn_rad: is missing or 0; give the turn of the table from a station "
                 "to the next");
  } else if (turns_rad > kFullTurn * (1 + 1e-6)) {
    LoadingError(errors, ErrorCode::kInvalidValue,
                 fmt::format(".turn_rad: {0:g} times {1} stations is more than a full "
                             "turn; give at most {2:.7g}",
                             loading.turn_rad(), loading.station_count(),
                             kFullTurn / loading.station_count()));
  }
}

/// A field that the other kind of machine has.
void CheckForeign(const MachineSpec& machine, std::vector<Error>& errors) {
  const Loading& loading = machine.loading();
  const auto refuse = [&](bool present, const char* field, const char* why) {
    if (!present) return;
    LoadingError(errors, ErrorCode::kInvalidValue,
                 fmt::format(".{}: {}; remove it", field, why));
  };
  constexpr char kLinear[] = "is of linear axes, a polar machine has turn_rad";
  constexpr char kPolar[] = "is of an arm and a table, a linear machine has pitch_mm";
  constexpr char kTwice[] = "is given beside offsets_mm, which has every station";
  if (machine.has_polar()) {
    refuse(!loading.offsets_mm().empty(), "offsets_mm", kLinear);
    return refuse(loading.has_pitch_mm(), "pitch_mm", kLinear);
  }
  refuse(loading.has_turn_rad(), "turn_rad", kPolar);
  refuse(loading.has_table_radius_mm(), "table_radius_mm", kPolar);
  if (loading.offsets_mm().empty()) return;
  refuse(loading.has_station_count(), "station_count", kTwice);
  refuse(loading.has_pitch_mm(), "pitch_mm", kTwice);
}

void CheckOnTable(const JobSpec& job, const MachineSpec& machine, Findings& findings) {
  const Loading& loading = machine.loading();
  if (!loading.has_table_radius_mm()) return;
  const Vec3 from = BlockOriginOf(machine, job), to = from + BlockSizeOf(job);
  const double reach_mm =
      from.head<2>().cwiseAbs().cwiseMax(to.head<2>().cwiseAbs()).maxCoeff();
  if (reach_mm <= loading.table_radius_mm() + kTouchMm) return;
  const Vec3 size_mm = BlockSizeOf(job);
  findings.Wrong("block.size_mm", fmt::format("{:g} x {:g}", size_mm.x(), size_mm.y()),
                 "does not lie on the table of {}: a side of the block is {:.6g} mm from "
                 "its axis, the radius of the table is {:g} mm; take a smaller block, or "
                 "correct loading.table_radius_mm",
                 machine.name(), reach_mm, loading.table_radius_mm());
}

void CheckBesideOthers(const JobSpec& job, const MachineSpec& machine,
                       Findings& findings) {
  const Vec3 size_mm = BlockSizeOf(job);
  const Vec3 first_mm =
      BlockOriginOf(machine, job) - StationPlaceOf(machine, job).offset_mm;
  const auto outline_at = [&](std::uint32_t station) {
    return OutlineOf(first_mm, size_mm, StationPlaceOf(machine, station));
  };
  const Outline own = outline_at(job.station());
  for (std::uint32_t other = 1; other <= StationCountOf(machine); ++other) {
    if (other == job.station() || !Overlap(own, outline_at(other))) continue;
    return findings.Wrong(
        "station", job.station(),
        "has no room beside station {} of {}: blocks of {:g} x {:g} x {:g} mm would "
        "overlap; engrave such blocks at station 1 alone, or correct loading",
        other, machine.name(), size_mm.x(), size_mm.y(), size_mm.z());
  }
}

}  // namespace

std::uint32_t StationCountOf(const MachineSpec& machine) {
  const Loading& loading = machine.loading();
  if (!loading.offsets_mm().empty())
    return 1 + static_cast<std::uint32_t>(loading.offsets_mm_size());
  return std::max<std::uint32_t>(1, loading.station_count());
}

StationPlace StationPlaceOf(const MachineSpec& machine, std::uint32_t station) {
  if (station < 2 || station > StationCountOf(machine)) return {};
  const Loading& loading = machine.loading();
  const double steps = station - 1;
  if (machine.has_polar())
    return {Vec3::Zero(), std::remainder(steps * loading.turn_rad(), kFullTurn)};
  if (loading.offsets_mm().empty()) return {steps * Vec3Of(loading.pitch_mm()), 0};
  return {Vec3Of(loading.offsets_mm(static_cast<int>(station) - 2)), 0};
}

StationPlace StationPlaceOf(const MachineSpec& machine, const JobSpec& job) {
  return StationPlaceOf(machine, job.station());
}

void CheckLoading(const MachineSpec& machine, std::vector<Error>& errors) {
  if (!machine.has_loading()) return;
  CheckForeign(machine, errors);
  if (machine.has_polar() || machine.loading().offsets_mm().empty())
    CheckByCount(machine, errors);
  if (machine.loading().offsets_mm_size() > 63) {
    LoadingError(errors, ErrorCode::kInvalidValue,
                 fmt::format(".offsets_mm: {} stations beside the first are more than 63",
                             machine.loading().offsets_mm_size()));
  }
}

void CheckStation(const JobSpec& job, const MachineSpec& machine, Findings& findings) {
  if (!machine.has_loading()) {
    if (!job.has_station()) return;
    return findings.Wrong("station", job.station(),
                          "is not known: the table of {} takes one block; remove it, or "
                          "give the profile a loading",
                          machine.name());
  }
  const std::uint32_t count = StationCountOf(machine);
  if (job.station() < 1 || job.station() > count) {
    return findings.Wrong("station", job.station(),
                          "is not a station of {}, which has {}; give 1 to {}",
                          machine.name(), count, count);
  }
  CheckOnTable(job, machine, findings);
  if (job.station() > 1) CheckBesideOthers(job, machine, findings);
}

}  // namespace intaglio
