#include "services/client/machine/cube_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/calibrate/cube_pattern.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/atomic_file.h"
#include "services/job/beams/job_beams.h"
#include "services/job/fields/shapes.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/machine_defaults.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

// From the faces of the block: nearer marks are hard to measure, and a crack breaks out.
constexpr double kFromFacesMm = 5;
// The usable radius and the field depend a little on the index of the glass.
constexpr double kOfReachShare = 0.97;
constexpr double kTypicalIndex = 1.52, kMmInNm = 1e-6;

/// How far from the axis the lowest marks are made, each at one depth, mm.
double ReachOf(const MachineSpec& machine, double depth_mm) {
  if (machine.lenses().empty()) return 0;
  const optics::FocusedBeam beam{kMmInNm * machine.laser().wavelength_nm(),
                                 machine.lenses(0).numerical_aperture(), kTypicalIndex};
  const auto strength = BeamStrengthOf(machine, beam, depth_mm);
  return std::min(strength.UsableRadiusMm(depth_mm, machine.laser().pulse_energy_mj()),
                  strength.DoubleRadiusMm(depth_mm));
}

/// What the marks may fill, glass frame. Empty where there is no room.
Box3 RoomOf(const CubeJob& asked, const MachineSpec& machine) {
  const double deepest_mm = asked.block_mm.z() - kFromFacesMm;
  const double half_mm =
      kOfReachShare * ReachOf(machine, std::max(1.0, deepest_mm)) / std::sqrt(2.0);
  const Vec3 origin_mm = Vec3Of(machine.block_origin_mm());
  Box3 room;
  for (int axis = 0; axis < 2; ++axis) {
    const auto& travel = axis == 0 ? machine.x() : machine.y();
    room.min_mm[axis] =
        std::max({kFromFacesMm, kOfReachShare * travel.travel_min_mm() - origin_mm[axis],
                  -half_mm - origin_mm[axis]});
    room.max_mm[axis] =
        std::min({asked.block_mm[axis] - kFromFacesMm,
                  kOfReachShare * travel.travel_max_mm() - origin_mm[axis],
                  half_mm - origin_mm[axis]});
  }
  room.min_mm.z() = kFromFacesMm;
  room.max_mm.z() = deepest_mm;
  return room;
}

std::string CubeTableOf(const calibrate::CubePattern& cube) {
  std::string text = "mark,x_mm,y_mm,z_mm,measured_x_mm,measured_y_mm,measured_z_mm\n";
  for (std::size_t i = 0; i < cube.marks_mm.size(); ++i) {
    const Vec3& at = cube.marks_mm[i];
    text += fmt::format("{},{:.4f},{:.4f},{:.4f},,,\n", i + 1, at.x(), at.y(), at.z());
  }
  return text;
}

JobSpec CubeJobOf(const CubeJob& asked) {
  JobSpec job;
  job.set_name("test cube");
  Model& cube = *job.add_models();
  cube.set_file("cube.ply");
  // The marks are where cube.csv has them: below the lens, which may be beside the
  // middle.
  cube.mutable_placement()->set_centre_in_block(false);
  Vector3& size = *job.mutable_block()->mutable_size_mm();
  size.set_x(asked.block_mm.x());
  size.set_y(asked.block_mm.y());
  size.set_z(asked.block_mm.z());
  job.set_glass(asked.glass);
  job.set_machine_file(asked.machine_file.string());
  return job;
}

}  // namespace

Result<fs::path> WriteCubeJob(const CubeJob& asked, const fs::path& folder) {
  const MachineSpec machine =
      WithMachineDefaults(INTAGLIO_TRY(ReadMachineFile(asked.machine_file)));
  if (!machine.has_head_over_block()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() + ": the test cube is for scan heads over a block");
  }
  const Box3 room = RoomOf(asked, machine);
  if (!((room.max_mm - room.min_mm).minCoeff() > 0)) {
    return Fail(ErrorCode::kOutsideBlock,
                fmt::format("{}: no cube is left of a block of {:g} x {:g} x {:g} mm: "
                            "block_origin_mm has to put it below the axis of the lens, "
                            "and the laser to make cracks {:g} mm deep (intaglio machine "
                            "check says how far from the axis it does)",
                            machine.name(), asked.block_mm.x(), asked.block_mm.y(),
                            asked.block_mm.z(), asked.block_mm.z() - kFromFacesMm));
  }
  const auto cube =
      INTAGLIO_TRY(calibrate::MakeCubePattern({room, asked.nodes, asked.levels}));
  std::error_code error;
  fs::create_directories(folder, error);
  formats::PointTable table;
  table.points_mm = cube.marks_mm;
  table.points_mm.insert(table.points_mm.end(), cube.signs_mm.begin(),
                         cube.signs_mm.end());
  INTAGLIO_TRY(formats::WritePly(folder / "cube.ply", table));
  INTAGLIO_TRY(
      io::WriteFileAtomically(folder / "cube.csv", std::string_view(CubeTableOf(cube))));
  const fs::path file = folder / "cube.textproto";
  INTAGLIO_TRY(WriteJobFile(file, CubeJobOf(asked)));
  return file;
}

}  // namespace intaglio::client
