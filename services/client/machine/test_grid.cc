// The grid stands upright in the middle of the block and faces the viewer in front: x to
// the right, z up. Row i of n has its middle at z = (i - (n - 1) / 2) pitch, the smallest
// energy at the bottom; so do the columns along x.

#include "services/client/machine/test_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "services/job/fields/field_path.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr double kMinPatchMm = 1, kMaxPatchMm = 50;
constexpr double kGapMm = 2;            // between patches, and to the labels
constexpr double kLabelHeightMm = 1.2;  // "0.125" is less than a patch wide
constexpr double kLabelWidthMm = 7;     // of the longest, "12.5 mJ"
constexpr double kMarginMm = 3;         // of a block without one of its own
constexpr double kDepthMm = 10;         // of a block that is chosen
constexpr int kDefaultEnergies = 4;
const std::string kMethod = "curves.";
constexpr double kMinShare = 0.4;  // of the largest energy

struct Grid {
  std::vector<double> energies_mj, spacings_mm;
  std::vector<int> pulses;  ///< none: columns by spacing
  double pitch_mm = 0;

  std::size_t columns() const {
    return pulses.empty() ? spacings_mm.size() : pulses.size();
  }
  double SpacingOf(std::size_t column) const {
    return pulses.empty() ? spacings_mm[column] : spacings_mm.front();
  }
  std::string LabelOfColumn(std::size_t column) const {
    return pulses.empty() ? fmt::format("{:.3g}", spacings_mm[column])
                          : fmt::format("{} x", pulses[column]);
  }

  /// Where row or column i of `count` has its middle, from the middle of the grid.
  double PlaceOf(std::size_t i, std::size_t count) const {
    return (static_cast<double>(i) - (static_cast<double>(count) - 1) / 2) * pitch_mm;
  }
  Vec3 size_mm() const {
    return {pitch_mm * static_cast<double>(columns()) + 2 * kLabelWidthMm, 0,
            pitch_mm * static_cast<double>(energies_mj.size()) + 4 * kGapMm};
  }
};

std::vector<double> DefaultEnergies(const MachineSpec& machine) {
  const EnergyRange range = SettableEnergies(machine);
  const double from_mj = std::max(range.min_mj, kMinShare * range.max_mj);
  std::vector<double> energies_mj;
  for (int i = 0; i < kDefaultEnergies; ++i) {
    const double share = static_cast<double>(i) / (kDefaultEnergies - 1);
    const double energy_mj = from_mj + share * (range.max_mj - from_mj);
    if (energies_mj.empty() || energy_mj > energies_mj.back())
      energies_mj.push_back(energy_mj);
  }
  return energies_mj;
}

Result<std::vector<double>> DefaultSpacings(const MachineSpec& machine) {
  const MachineLens* lens = MountedLensOf(machine);
  if (lens == nullptr || lens->crack_diameter_mm() <= 0) {
    return Fail(ErrorCode::kInvalidValue,
                machine.name() +
                    ": the crack of its lens is not known; give the distances "
                    "of the points with --spacings",
                machine.name());
  }
  std::vector<double> spacings_mm;
  for (const double factor : {1.0, 1.25, 1.5, 2.0})
    spacings_mm.push_back(factor * lens->crack_diameter_mm());
  return spacings_mm;
}

Model PatchOf(double energy_mj, double spacing_mm) {
  Model model;
  model.set_file("patch.svg");
  model.set_pulse_energy_mj(energy_mj);
  const bool set =
      SetField(model, kMethod + "distance_mm", fmt::format("{}", spacing_mm)) &&
      SetField(model, fmt::format("{}fill", kMethod), "true");
  Require(set, "a drawing has no distance {} or no filling", spacing_mm);
  return model;
}

Model LabelOf(const std::string& words) {
  Model model;
  model.mutable_text()->set_text(words);
  model.mutable_text()->set_font("DejaVu Sans");
  model.mutable_text()->set_height_mm(kLabelHeightMm);
  return model;
}

void Put(Model model, double x_mm, double z_mm, JobSpec& job) {
  Vector3& move = *model.mutable_placement()->mutable_move_mm();
  move.set_x(x_mm);
  move.set_z(z_mm);
  *job.add_models() = std::move(model);
}

/// The columns from `begin` to `end`; the labels of the rows are beside the first.
JobSpec JobOf(const TestGrid& asked, const Grid& grid, const Vec3& block_mm,
              std::size_t begin, std::size_t end) {
  JobSpec job;
  job.set_name("test grid");
  job.set_glass(asked.glass);
  job.set_machine_file(asked.machine_file.string());
  // Each patch has the energy that its label names.
  job.mutable_laser()->set_energy_by_place(false);
  Vector3& size = *job.mutable_block()->mutable_size_mm();
  size.set_x(block_mm.x());
  size.set_y(block_mm.y());
  size.set_z(block_mm.z());
  job.mutable_discretization()->set_min_spacing_mm(
      *std::ranges::min_element(grid.spacings_mm));
  const std::size_t rows = grid.energies_mj.size(), columns = grid.columns();
  for (std::size_t i = 0; i < rows; ++i) {
    const double z_mm = grid.PlaceOf(i, rows);
    for (std::size_t j = begin; j < end; ++j) {
      Put(PatchOf(grid.energies_mj[i], grid.SpacingOf(j)), grid.PlaceOf(j, columns), z_mm,
          job);
    }
    if (begin > 0) continue;
    Put(LabelOf(fmt::format("{:.3g} mJ", grid.energies_mj[i])),
        grid.PlaceOf(0, columns) - (grid.pitch_mm + kLabelWidthMm) / 2, z_mm, job);
  }
  for (std::size_t j = begin; j < end; ++j) {
    Put(LabelOf(grid.LabelOfColumn(j)), grid.PlaceOf(j, columns),
        grid.PlaceOf(0, rows) - (grid.pitch_mm + kGapMm) / 2, job);
  }
  return job;
}

Result<Vec3> BlockOf(const TestGrid& asked, const Grid& grid) {
  const Vec3 needed_mm = grid.size_mm() + Vec3::Constant(2 * kMarginMm);
  if (!asked.block_mm) return Vec3(needed_mm.x(), kDepthMm, needed_mm.z());
  if (asked.block_mm->x() >= needed_mm.x() && asked.block_mm->z() >= needed_mm.z())
    return *asked.block_mm;
  return Fail(
      ErrorCode::kOutsideBlock,
      fmt::format("a grid of {} x {} patches needs a block {:g} mm wide and {:g} "
                  "mm high; give fewer energies or columns, or a smaller --patch",
                  grid.columns(), grid.energies_mj.size(), needed_mm.x(), needed_mm.z()),
      fmt::format("{:g}", asked.block_mm->x()));
}

Result<Grid> GridOf(const TestGrid& asked, const MachineSpec& machine) {
  if (!(asked.patch_mm >= kMinPatchMm && asked.patch_mm <= kMaxPatchMm)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--patch: {:g} mm is outside {:g}..{:g}", asked.patch_mm,
                            kMinPatchMm, kMaxPatchMm),
                fmt::format("{:g}", asked.patch_mm));
  }
  if (!asked.pulses.empty() && asked.spacings_mm.size() > 1) {
    return Fail(ErrorCode::kInvalidValue,
                "--spacings: columns are by --pulses; give one spacing", "--spacings");
  }
  Grid grid;
  grid.pulses = asked.pulses;
  grid.pitch_mm = asked.patch_mm + kGapMm;
  grid.energies_mj =
      asked.energies_mj.empty() ? DefaultEnergies(machine) : asked.energies_mj;
  grid.spacings_mm = asked.spacings_mm.empty() ? INTAGLIO_TRY(DefaultSpacings(machine))
                                               : asked.spacings_mm;
  if (!grid.pulses.empty() && asked.spacings_mm.empty())
    grid.spacings_mm = {grid.spacings_mm.at(1)};
  return grid;
}

}  // namespace

Result<std::vector<fs::path>> WriteTestGrid(const TestGrid& asked,
                                            const fs::path& folder) {
  const MachineSpec machine = INTAGLIO_TRY(ReadMachineFile(asked.machine_file));
  const Grid grid = INTAGLIO_TRY(GridOf(asked, machine));
  const Vec3 block_mm = INTAGLIO_TRY(BlockOf(asked, grid));
  std::error_code error;
  fs::create_directories(folder, error);
  const std::string patch = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{0}mm\" "
      "viewBox=\"0 0 {0} {0}\">\n<rect width=\"{0}\" height=\"{0}\"/>\n</svg>\n",
      asked.patch_mm);
  INTAGLIO_TRY(io::WriteFileAtomically(folder / "patch.svg", std::string_view(patch)));
  if (grid.pulses.empty()) {
    const fs::path file = folder / "test_grid.textproto";
    INTAGLIO_TRY(WriteJobFile(file, JobOf(asked, grid, block_mm, 0, grid.columns())));
    return std::vector<fs::path>{file};
  }
  std::vector<fs::path> files;
  for (std::size_t column = 0; column < grid.columns(); ++column) {
    const int pulses = grid.pulses[column];
    JobSpec job = JobOf(asked, grid, block_mm, column, column + 1);
    job.set_name("test grid, " + Counted(pulses, "pulse"));
    job.mutable_laser()->set_pulses_per_point(static_cast<std::uint32_t>(pulses));
    files.push_back(folder / fmt::format("test_grid-{}-pulses.textproto", pulses));
    INTAGLIO_TRY(WriteJobFile(files.back(), job));
  }
  return files;
}

}  // namespace intaglio::client
