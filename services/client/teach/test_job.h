#pragma once

// Jobs of a test pulse and of a focus series at the present place of a machine: ordinary
// jobs of points, which go through the same chain and need the same arm as any other.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/job/teach/test_points.h"

namespace intaglio::client {

/// The stage's way over that of the focus in a glass of this name, with this lens
/// (materials_db/material.h).
using StagePerGlass = std::function<Result<double>(
    const MachineSpec& machine, const MachineLens& lens, const std::string& glass)>;

struct TestJob {
  std::filesystem::path machine_file;  ///< absolute; with what was taught
  Vec3 axes = Vec3::Zero();            ///< where the axes are
  Vec3 block_mm = Vec3::Zero();
  std::string glass = "N-BK7";  ///< by a name of the material base
  std::string lens = {};        ///< empty: the mounted one
  std::uint32_t channel = 1;
  /// mJ; default: a tenth of the laser's, and not below its calibration.
  std::optional<double> energy_mj = {};
  /// To which the laser is set, nm; default the profile's laser.wavelength_nm.
  std::optional<double> wavelength_nm = {};
};

/// Names of the files in a job's folder.
inline constexpr char kTestPoints[] = "points.xyz", kTestJob[] = "job.textproto";

/// One point where the focus is. Writes points and job into `folder`, and makes it;
/// returns the job file. Errors: of the profile, the glass, the place, the disk.
Result<std::filesystem::path> WriteTestPulse(const TestJob& job,
                                             const StagePerGlass& stage_per_glass,
                                             const std::filesystem::path& folder);
/// A row from the top face down.
Result<std::filesystem::path> WriteFocusSeries(const TestJob& job,
                                               const StagePerGlass& stage_per_glass,
                                               const FocusSeries& series,
                                               const std::filesystem::path& folder);

/// How a zero has to move.
struct ZeroMove {
  double z_mm = 0;
  std::string lens;
  std::uint32_t channel = 1;
};

/// By the series of the job in `folder`, of which crack `first` (from 1) is the first
/// that is visible. Errors: of the files, and of ZeroMoveOfFirstCrack.
Result<ZeroMove> ZeroMoveOfSeries(const std::filesystem::path& folder,
                                  std::uint32_t first,
                                  const StagePerGlass& stage_per_glass);

}  // namespace intaglio::client
