// The fixtures of a profile are named from the block at station 1. Another station lies
// `offset` from it and is turned by t about the axis of the table, which is the origin of
// the machine frame: a place p from the corner of station 1, block origin o, is
//   R(-t) (o + p) - o - offset
// from the corner of that station.

#include "services/job/machine/head_clearance.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <optional>

#include "engrave/core/counted.h"
#include "engrave/optics/focus.h"
#include "engrave/optics/machine_frame.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/stations.h"

namespace intaglio {
namespace {

Box3 AtStation(const Fixture& fixture, const MachineSpec& machine,
               const StationPlace& station) {
  const Vec3 origin_mm = Vec3Of(machine.block_origin_mm());
  const Eigen::AngleAxisd back(-station.turn_rad, Vec3::UnitZ());
  const Box3 own{Vec3Of(fixture.min_mm()), Vec3Of(fixture.max_mm())};
  Box3 box;
  for (const double x : {own.min_mm.x(), own.max_mm.x()}) {
    for (const double y : {own.min_mm.y(), own.max_mm.y()}) {
      for (const double z : {own.min_mm.z(), own.max_mm.z()}) {
        box.Extend(
            Vec3(back * (origin_mm + Vec3(x, y, z)) - origin_mm - station.offset_mm));
      }
    }
  }
  return box;
}

machine::BeamBody BodyOf(const MachineLens& lens) {
  machine::BeamBody body{FreeDistanceMm(lens)};
  if (lens.has_mount_diameter_mm()) body.radius_mm = lens.mount_diameter_mm() / 2;
  return body;
}

/// A point, or the way to it, that is refused.
struct Worst {
  std::uint64_t count = 0;
  std::size_t point = 0;
  bool on_the_way = false;
  std::optional<machine::Collision> collision;

  void Add(std::size_t at, bool way, const machine::Collision& found) {
    ++count;
    if (collision && found.overlap_mm <= collision->overlap_mm) return;
    point = at, on_the_way = way, collision = found;
  }
};

Worst FindWorst(const machine::Clearance& clearance, const FrozenJob& job,
                const PointList& points_mm, PointOrder order) {
  const optics::MachineFromGlass frame{Vec3::Zero(), BlockSizeOf(job.job()),
                                       job.optics().stage_per_glass_ratio()};
  Worst worst;
  Vec3 before_mm = Vec3::Zero();
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    const Vec3 focus_mm = frame.ToMachine(points_mm[i]);
    if (const auto at = clearance.At(focus_mm)) {
      worst.Add(i, false, *at);
    } else if (order == PointOrder::kOfEngraving && i > 0) {
      if (const auto way = clearance.Along(before_mm, focus_mm)) worst.Add(i, true, *way);
    }
    before_mm = focus_mm;
  }
  return worst;
}

/// "the lens f70, which reaches 100 mm deep", for those that reach it; else empty.
std::string OtherLenses(const FrozenJob& job, double depth_mm) {
  std::string text;
  for (const MachineLens& lens : job.machine().lenses()) {
    if (lens.focal_length_mm() == job.job().lens().focal_length_mm()) continue;
    const double aperture = lens.numerical_aperture();
    if (job.optics().refractive_index() < 1 || aperture <= 0 || aperture >= 1) continue;
    const double reach_mm = ReachMm(
        lens, optics::StagePerGlassRatio(job.optics().refractive_index(), aperture));
    if (reach_mm < depth_mm) continue;
    text += fmt::format(", or take the lens {}, which reaches {:.1f} mm deep",
                        lens.name(), reach_mm);
  }
  return text;
}

std::string PlaceText(const Vec3& p) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) mm", p.x(), p.y(), p.z());
}

std::string WhereFrom(const MachineLens& lens, const machine::Collision& collision,
                      const std::string& machine) {
  if (collision.body > 0) {
    return fmt::format("head_body and working_distance_mm of the profile of {}", machine);
  }
  if (lens.has_free_distance_mm()) {
    return fmt::format(
        "its lowest edge is {:g} mm above its focus in air, free_distance_"
        "mm of the profile of {}",
        lens.free_distance_mm(), machine);
  }
  return fmt::format(
      "the profile of {} has no free_distance_mm, so its lowest edge is "
      "taken to be at its focal length, {:g} mm above its focus in air",
      machine, lens.focal_length_mm());
}

tl::unexpected<Error> Refuse(const FrozenJob& job, const MachineLens& lens,
                             const HeadClearance& head, const PointList& points_mm,
                             const Worst& worst) {
  const Vec3& at_mm = points_mm[worst.point];
  const machine::Collision& collision = *worst.collision;
  const double depth_mm = BlockSizeOf(job.job()).z() - at_mm.z();
  const std::string& solid = head.solids[collision.solid];
  const std::string remedy =
      collision.solid == 0 ? "place the model higher in the block, take a lower block" +
                                 OtherLenses(job, depth_mm)
                           : "place the model away from it, or move it";
  return Fail(
      ErrorCode::kOutsideBlock,
      fmt::format("{} of {} would bring the head into {}: {} point {}, "
                  "{:.1f} mm below the top face, {} would be {:.1f} mm inside {} "
                  "({}); {}",
                  worst.count, Counted(points_mm.size(), "point"), solid,
                  worst.on_the_way ? "on the way to" : "at", PlaceText(at_mm), depth_mm,
                  head.bodies[collision.body], collision.overlap_mm, solid,
                  WhereFrom(lens, collision, job.machine().name()), remedy),
      fmt::format("{}", collision.overlap_mm));
}

}  // namespace

double FreeDistanceMm(const MachineLens& lens) {
  return lens.has_free_distance_mm() ? lens.free_distance_mm() : lens.focal_length_mm();
}

double ReachMm(const MachineLens& lens, double stage_per_glass_ratio) {
  return FreeDistanceMm(lens) / stage_per_glass_ratio;
}

HeadClearance HeadClearanceOf(const JobSpec& job, const MachineSpec& machine) {
  HeadClearance head;
  std::vector<machine::BeamBody> bodies;
  std::vector<Box3> solids = {{Vec3::Zero(), BlockSizeOf(job)}};
  head.solids = {"the block"};
  if (const MachineLens* lens = FindLens(machine, job.lens().focal_length_mm())) {
    bodies.push_back(BodyOf(*lens));
    head.bodies.push_back(fmt::format("the lens {}", lens->name()));
    if (machine.has_head_body() && lens->has_working_distance_mm()) {
      const HeadBody& body = machine.head_body();
      bodies.push_back({lens->working_distance_mm() + body.above_reference_mm(),
                        body.diameter_mm() / 2});
      head.bodies.push_back(fmt::format("the head of {}", machine.name()));
    }
  }
  const StationPlace station = StationPlaceOf(machine, job);
  for (const Fixture& fixture : machine.fixtures()) {
    solids.push_back(AtStation(fixture, machine, station));
    head.solids.push_back(fmt::format("the fixture \"{}\"", fixture.name()));
  }
  head.clearance = machine::Clearance(std::move(bodies), std::move(solids));
  return head;
}

Status CheckHeadClearance(const FrozenJob& job, const PointList& points_mm,
                          PointOrder order) {
  const MachineLens* lens = FindLens(job.machine(), job.job().lens().focal_length_mm());
  if (lens == nullptr) return {};
  const HeadClearance head = HeadClearanceOf(job.job(), job.machine());
  const Worst worst = FindWorst(head.clearance, job, points_mm, order);
  if (worst.count > 0) return Refuse(job, *lens, head, points_mm, worst);
  return {};
}

}  // namespace intaglio
