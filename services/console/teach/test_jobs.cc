#include "services/console/teach/test_jobs.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "services/client/proof/evidence/proof_evidence.h"
#include "services/client/teach/test_job.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

client::TestJob TestJobOf(const client::MachineView& machine,
                          const TestJobRequest& request) {
  client::TestJob job;
  job.machine_file = machine.profile;
  job.axes = machine.position;
  job.block_mm = {request.block_x_mm(), request.block_y_mm(), request.block_z_mm()};
  if (!request.glass().empty()) job.glass = request.glass();
  job.lens = request.lens();
  if (request.channel() != 0) job.channel = request.channel();
  if (request.energy_mj() != 0) job.energy_mj = request.energy_mj();
  return job;
}

FocusSeries SeriesOf(const TestJobRequest& request) {
  FocusSeries series;
  if (request.step_mm() != 0) series.step_mm = request.step_mm();
  if (request.count() != 0) series.count = request.count();
  if (request.pitch_mm() != 0) series.pitch_mm = request.pitch_mm();
  return series;
}

}  // namespace

Result<fs::path> WriteTestJob(const client::MachineView& machine, TestKind kind,
                              const TestJobRequest& request,
                              const client::StagePerGlass& stage_per_glass,
                              const fs::path& folder) {
  if (machine.profile.empty()) {
    return Fail(ErrorCode::kMissing,
                machine.cell + ": has no profile, and so no test pulse");
  }
  if (!machine.homed) {
    return Fail(ErrorCode::kRefused,
                "the controller does not know where its axes are: home it first");
  }
  const client::TestJob job = TestJobOf(machine, request);
  return kind == TestKind::kPulse
             ? client::WriteTestPulse(job, stage_per_glass, folder)
             : client::WriteFocusSeries(job, stage_per_glass, SeriesOf(request), folder);
}

Result<SeriesZeroMove> ZeroMoveOf(const client::MachineView& machine,
                                  const fs::path& result_folder, std::uint32_t first,
                                  const client::StagePerGlass& stage_per_glass) {
  const auto frozen = INTAGLIO_TRY(client::ReadFrozenJob(result_folder / "job.json"));
  if (frozen.job().models_size() != 1 || frozen.job().machine_file() != machine.profile) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} is no focus series of {}: choose one",
                            frozen.job().name(), machine.cell));
  }
  const auto move = INTAGLIO_TRY(client::ZeroMoveOfSeries(
      fs::path(frozen.job().models(0).file()).parent_path(), first, stage_per_glass));
  SeriesZeroMove answer;
  answer.set_z_mm(move.z_mm);
  answer.set_lens(move.lens);
  answer.set_channel(move.channel);
  return answer;
}

}  // namespace intaglio::console
