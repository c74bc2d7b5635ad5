#include "services/synchronizer/job_preparation.h"

#include <fmt/format.h>

#include <filesystem>

#include "engrave/core/try.h"
#include "engrave/formats/journal_file.h"
#include "services/job/beams/energy_by_place.h"
#include "services/job/convert/options.h"
#include "services/job/fields/channels.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/head_clearance.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/pulse_energies.h"
#include "services/synchronizer/job_folder.h"
#include "services/synchronizer/path_check.h"

namespace intaglio::synchronizer {
namespace {

constexpr std::uint64_t kSteps = 3;

Result<PointCloud> PathOf(PreparationTask& task) {
  auto path = task.path ? Result<PointCloud>(std::move(*task.path))
                        : ReadPath(task.job.result_directory());
  if (path && path->size() == 0) {
    return Fail(ErrorCode::kInvalidValue, "the job has no points: nothing to engrave");
  }
  return path;
}

Result<EngravingJob> EngravingOf(const PreparationTask& task, const PointCloud& path) {
  const FrozenJob& frozen = task.job;
  EngravingJob job;
  job.uid = frozen.job_uid();
  job.plan = MotionOptionsOf(frozen);
  job.machine_limits = AxisLimitsOf(frozen.machine());
  job.trigger = FindPulseTrigger(frozen.machine().pulse_trigger());
  if (job.trigger == nullptr) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("pulse_trigger: this synchronizer knows no trigger {}",
                            static_cast<int>(frozen.machine().pulse_trigger())));
  }
  job.trigger->Adapt(job.plan);
  job.machine_from_glass = AxesFromGlassOf(frozen);
  const auto frames = AxesFromGlassOfModels(frozen);
  auto axes = INTAGLIO_TRY(
      CheckedAxes(path, BlocksOfModels(frozen.job()), frames, job.plan.limits.travel_mm));
  job.machine_points_mm = std::move(axes);
  INTAGLIO_TRY(CheckHeadClearance(frozen, path.points_mm, PointOrder::kOfEngraving));
  auto energies = INTAGLIO_TRY(EnergiesOfPoints(frozen, path.points_mm, path.source));
  job.energies = std::move(energies);
  job.max_missed_in_a_row = frozen.machine().laser().max_missed_in_a_row();
  job.needs_door_lock = frozen.machine().laser().door_lock();
  job.max_unsettled_points = frozen.machine().laser().max_unsettled_points();
  // Others make one by themselves.
  if (frozen.machine().head_over_block().has_jump_and_dwell()) {
    job.pulses_per_point =
        static_cast<std::uint16_t>(frozen.job().laser().pulses_per_point());
  }
  job.photosensor_feedback = frozen.job().laser().photosensor_feedback();
  job.position_tolerance_um = frozen.machine().position_tolerance_um();
  job.block_stage_mm = BlockStageOf(frozen);
  job.asks_when_uncertain = frozen.job().when_uncertain() == UNCERTAIN_POINTS_ASK;
  job.block_misfit = task.block_misfit;
  auto masks = INTAGLIO_TRY(ChannelsOfPoints(frozen.job(), path.source));
  job.shutter_mask = masks.front();
  if (DistinctMasks(masks).size() > 1) job.masks = std::move(masks);
  if (!AreHeadCoordinates(frozen.machine())) {
    job.places_mm.reserve(path.size());
    for (std::size_t i = 0; i < path.size(); ++i) {
      const auto& frame = frames[path.source[i] < frames.size() ? path.source[i] : 0];
      job.places_mm.push_back(frame.machine_from_glass().ToMachine(path.points_mm[i]));
    }
  }
  job.cone = PointConeInMachine(frozen);
  return job;
}

Result<OpenedJournal> OpenFolder(const PreparationTask& task, const PointCloud& path,
                                 bool on_disk) {
  const std::filesystem::path folder = task.job.result_directory();
  INTAGLIO_TRY(MakeJobFolder(folder));
  // Before the plan is written over: it may be refused for another's pulses.
  auto journal = OpenJournal(folder / kJournalFile,
                             {path.size(), task.job.epoch(),
                              formats::PathCrc(path.points_mm), task.job.job().station()},
                             on_disk ? JobBegun::kItsPathIsThere : JobBegun::kNo);
  if (!journal || (on_disk && !task.begins_anew)) return journal;
  INTAGLIO_TRY(WritePlan(folder, task.job, path));
  return journal;
}

}  // namespace

Result<PreparedJob> PrepareJob(PreparationTask task, const ProgressSink& progress) {
  const bool on_disk = !task.path.has_value();
  std::uint64_t steps = 0;
  const auto wanted = [&] { return progress(++steps, kSteps); };
  const auto cancelled = [] {
    return Fail(ErrorCode::kCancelled, "the job was cancelled during its preparation");
  };
  const auto path = INTAGLIO_TRY(PathOf(task));
  if (!wanted()) return cancelled();
  auto job = INTAGLIO_TRY(EngravingOf(task, path));
  if (!wanted()) return cancelled();
  auto journal = INTAGLIO_TRY(OpenFolder(task, path, on_disk));
  job.earlier = std::move(journal.earlier);
  PlanInput plan{job.machine_points_mm, job.plan, job.masks,
                 ScaleBoundsOf(task.job).any_mm};
  return PreparedJob{std::move(job), std::move(journal.writer), std::move(task.job),
                     std::move(plan)};
}

}  // namespace intaglio::synchronizer
