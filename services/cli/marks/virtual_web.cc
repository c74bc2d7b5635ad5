#include "services/cli/marks/virtual_web.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/planned_marks.h"
#include "services/job/models/program_limits.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {

Result<double> VirtualWebSpeed(const JobSpec& job, const MachineSpec& machine,
                               double size_limits) {
  if (!job.marks().has_web() || !(machine.scan_head().encoder_count_um() > 0)) return 0;
  if (job.marks().web().speed_mm_s() > 0) return job.marks().web().speed_mm_s();
  const ReadLimits limits = mesh_reader::LimitsOfProgram(size_limits);
  auto files = INTAGLIO_TRY(ReadJobMarkFiles(job, limits));
  Warnings ignored;  // the discretizer reports them
  const auto planned = INTAGLIO_TRY(PlannedMarks::Make(
      job, machine, std::move(files), limits, host::AllCores(), ignored, {}));
  const double largest_mm_s = INTAGLIO_TRY(*planned.web()).max_mm_s;
  return std::min(kVirtualWebShare * largest_mm_s,
                  machine.scan_head().field_mm() / kVirtualWebS);
}

}  // namespace intaglio::cli
