#include "services/client/teach/test_job.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <algorithm>

#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/atomic_file.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/fields/shapes.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

// Weak enough for a mark that is measured, and not to break a block at its face.
constexpr double kEnergyShare = 0.1;
// Below the distance of the points, so that none is thinned out.
constexpr double kSpacingShare = 0.9;
constexpr double kPulseSpacing_mm = 0.1;

Result<const MachineLens*> LensOf(const MachineSpec& machine, const std::string& name) {
  const MachineLens* lens =
      name.empty() ? MountedLensOf(machine) : FindLensNamed(machine, name);
  if (lens != nullptr) return lens;
  return Fail(ErrorCode::kNotFound,
              fmt::format("lens: \"{}\" is not a lens of {}", name, machine.name()),
              name);
}

double EnergyOf(const TestJob& asked, const MachineSpec& machine) {
  if (asked.energy_mj) return *asked.energy_mj;
  const EnergyRange settable = SettableEnergies(machine);
  return std::clamp(kEnergyShare * machine.laser().pulse_energy_mj(), settable.min_mj,
                    settable.max_mj);
}

JobSpec JobOf(const TestJob& asked, const std::string& name, const MachineSpec& machine,
              const MachineLens& lens, double spacing_mm) {
  JobSpec job;
  job.set_name(name);
  job.add_models()->set_file(kTestPoints);
  Vector3& size = *job.mutable_block()->mutable_size_mm();
  size.set_x(asked.block_mm.x());
  size.set_y(asked.block_mm.y());
  size.set_z(asked.block_mm.z());
  job.mutable_block()->set_margin_mm(0);
  job.set_glass(asked.glass);
  job.mutable_lens()->set_focal_length_mm(lens.focal_length_mm());
  job.mutable_discretization()->set_min_spacing_mm(spacing_mm);
  job.mutable_laser()->set_pulse_energy_mj(EnergyOf(asked, machine));
  if (asked.wavelength_nm) job.mutable_laser()->set_wavelength_nm(*asked.wavelength_nm);
  job.mutable_laser()->add_channels(asked.channel);
  // What is asked for is tried.
  job.mutable_laser()->set_energy_by_place(false);
  // In the air no sensor sees a crack, and a weak pulse may leave none.
  job.mutable_laser()->set_photosensor_feedback(false);
  job.set_machine_file(asked.machine_file.string());
  return job;
}

Result<fs::path> Write(const JobSpec& job, const PointList& points_mm,
                       const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  formats::PointTable table;
  table.points_mm = points_mm;
  INTAGLIO_TRY(formats::WriteXyz(folder / kTestPoints, table));
  std::string text;
  google::protobuf::TextFormat::PrintToString(job, &text);
  const fs::path file = folder / kTestJob;
  INTAGLIO_TRY(io::WriteFileAtomically(file, std::string_view(text)));
  return file;
}

/// What both kinds of job are made from.
struct Bench {
  MachineSpec machine;
  const MachineLens* lens = nullptr;
  optics::MachineFromGlass frame;
};

Status Prepare(const TestJob& asked, const StagePerGlass& stage_per_glass, Bench& bench) {
  bench.machine = INTAGLIO_TRY(ReadMachineFile(asked.machine_file));
  if (asked.wavelength_nm)
    bench.machine = ForWavelength(*asked.wavelength_nm, std::move(bench.machine));
  if (!asked.block_mm.allFinite() || !(asked.block_mm.array() > 0).all())
    return Fail(ErrorCode::kInvalidValue, "block: give its size, mm, above 0");
  const std::uint32_t channels = bench.machine.laser().channels();
  if (asked.channel < 1 || asked.channel > channels) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("channel {}: {} has the channels 1 to {}", asked.channel,
                            bench.machine.name(), channels),
                std::to_string(asked.channel));
  }
  bench.lens = INTAGLIO_TRY(LensOf(bench.machine, asked.lens));
  const double ratio =
      INTAGLIO_TRY(stage_per_glass(bench.machine, *bench.lens, asked.glass));
  bench.frame =
      TestFrame(bench.machine, asked.channel, bench.lens->name(), asked.block_mm, ratio);
  return {};
}

}  // namespace

Result<fs::path> WriteTestPulse(const TestJob& job, const StagePerGlass& stage_per_glass,
                                const fs::path& folder) {
  Bench bench;
  INTAGLIO_TRY(Prepare(job, stage_per_glass, bench));
  const Vec3 point_mm =
      INTAGLIO_TRY(PointUnderFocus(bench.machine, job.axes, bench.frame));
  return Write(JobOf(job, "test pulse", bench.machine, *bench.lens, kPulseSpacing_mm),
               {point_mm}, folder);
}

Result<fs::path> WriteFocusSeries(const TestJob& job,
                                  const StagePerGlass& stage_per_glass,
                                  const FocusSeries& series, const fs::path& folder) {
  Bench bench;
  INTAGLIO_TRY(Prepare(job, stage_per_glass, bench));
  const PointList points_mm =
      INTAGLIO_TRY(FocusSeriesPoints(bench.machine, job.axes, bench.frame, series));
  return Write(JobOf(job, "focus series", bench.machine, *bench.lens,
                     kSpacingShare * series.pitch_mm),
               points_mm, folder);
}

Result<ZeroMove> ZeroMoveOfSeries(const fs::path& folder, std::uint32_t first,
                                  const StagePerGlass& stage_per_glass) {
  const JobSpec job = INTAGLIO_TRY(ReadJobFile(folder / kTestJob));
  const auto points = INTAGLIO_TRY(formats::ReadXyz(folder / kTestPoints));
  const MachineSpec machine =
      ForWavelengthOf(job.laser(), INTAGLIO_TRY(ReadMachineFile(job.machine_file())));
  const MachineLens* lens = FindLens(machine, job.lens().focal_length_mm());
  if (lens == nullptr || points.points_mm.size() < 2 ||
      job.laser().channels_size() != 1) {
    return Fail(ErrorCode::kInvalidValue,
                (folder / kTestJob).string() +
                    " is no focus series of this machine: name the folder that "
                    "`intaglio teach focus` has written");
  }
  const double ratio = INTAGLIO_TRY(stage_per_glass(machine, *lens, job.glass()));
  ZeroMove move;
  move.z_mm = INTAGLIO_TRY(
      ZeroMoveOfFirstCrack(points.points_mm, job.block().size_mm().z(), ratio, first));
  move.lens = lens->name();
  move.channel = job.laser().channels(0);
  return move;
}

}  // namespace intaglio::client
