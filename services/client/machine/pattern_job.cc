#include "services/client/machine/pattern_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "engrave/calibrate/test_pattern.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "services/job/checks/mark_job_check.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

// The rest accelerates and brakes between the rows.
constexpr double kSpeedShare = 0.8;
// Below the distance of the marks, so that none is thinned out.
constexpr double kSpacingShare = 0.9;

/// The highest rate at which a step a tick is not too fast.
std::optional<double> RateFor(const MachineSpec& machine, double step_mm) {
  const Vec3 speed_mm_s = AxisLimitsOf(machine).max_speed_mm_s;
  const double fastest_mm_s = kSpeedShare * std::min(speed_mm_s.x(), speed_mm_s.y());
  std::optional<double> rate_hz;
  for (const double rate : machine.laser().rates_hz()) {
    if (rate * step_mm <= fastest_mm_s && rate > rate_hz.value_or(0)) rate_hz = rate;
  }
  return rate_hz;
}

JobSpec JobOf(const PatternJob& asked, const calibrate::TestPatternOptions& options,
              const calibrate::TestPattern& pattern, double rate_hz) {
  JobSpec job;
  job.set_name("test pattern");
  job.add_models()->set_file("pattern.ply");
  Vector3& size = *job.mutable_block()->mutable_size_mm();
  size.set_x(asked.block_mm.x());
  size.set_y(asked.block_mm.y());
  size.set_z(asked.block_mm.z());
  job.mutable_block()->set_margin_mm(options.margin_mm - 0.1);
  job.set_glass(asked.glass);
  job.mutable_discretization()->set_min_spacing_mm(kSpacingShare * options.slow_step_mm);
  BoustrophedonOrder& order = *job.mutable_ordering()->mutable_boustrophedon();
  order.set_layer_thickness_mm(pattern.layer_mm);
  order.set_row_width_mm(pattern.row_width_mm);
  job.mutable_motion()->set_profile(MOTION_PROFILE_CONTINUOUS);
  job.mutable_laser()->set_rate_hz(rate_hz);
  job.mutable_laser()->add_channels(1);
  job.set_machine_file(asked.machine_file.string());
  return job;
}

}  // namespace

Result<fs::path> WritePatternJob(const PatternJob& asked, const fs::path& folder) {
  const MachineSpec machine = INTAGLIO_TRY(ReadMachineFile(asked.machine_file));
  INTAGLIO_TRY(CheckMakesPoints(machine));
  if (machine.has_head_over_block()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() +
                    ": its mirrors tilt the beam, and the test pattern is for three "
                    "linear axes; a test cube is for it");
  }
  if (machine.has_polar()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() +
                    ": its axes turn, and the test pattern is for three "
                    "linear axes");
  }
  calibrate::TestPatternOptions options;
  options.block_mm = asked.block_mm;
  const auto rate_hz = RateFor(machine, options.fast_step_mm);
  if (!rate_hz) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{}: at its lowest lamp rate x and y are too slow for marks "
                            "{} mm apart in consecutive ticks; correct max_speed_mm_s or "
                            "laser.rates_hz",
                            machine.name(), options.fast_step_mm));
  }
  const auto pattern = INTAGLIO_TRY(calibrate::MakeTestPattern(options));
  std::error_code error;
  fs::create_directories(folder, error);
  formats::PointTable table;
  table.points_mm = pattern.marks_mm;
  INTAGLIO_TRY(formats::WritePly(folder / "pattern.ply", table));
  const fs::path file = folder / "pattern.textproto";
  INTAGLIO_TRY(WriteJobFile(file, JobOf(asked, options, pattern, *rate_hz)));
  return file;
}

}  // namespace intaglio::client
