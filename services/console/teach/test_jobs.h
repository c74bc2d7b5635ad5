#pragma once

// Test pulses and focus series from a page: the jobs of `intaglio teach pulse` and
// `intaglio teach focus` (services/client/teach/test_job.h).

#include <filesystem>
#include <string>

#include "engrave/core/result.h"
#include "proto/console.pb.h"
#include "services/client/teach/stage_per_glass.h"
#include "services/client/teach_client.h"

namespace intaglio::console {

enum class TestKind { kPulse, kFocus };

/// Writes the job with the axes where `machine` has them into `folder`; the job file.
/// kRefused: the axes are not homed; kMissing: the machine has no profile; the errors of
/// WriteTestPulse and WriteFocusSeries.
Result<std::filesystem::path> WriteTestJob(const client::MachineView& machine,
                                           TestKind kind, const TestJobRequest& request,
                                           const client::StagePerGlass& stage_per_glass,
                                           const std::filesystem::path& folder);

/// By the series whose job has its results in `result_folder`. kNotFound: these are on
/// another computer; kInvalidValue: it is no series of this machine, or has no crack
/// `first`.
Result<SeriesZeroMove> ZeroMoveOf(const client::MachineView& machine,
                                  const std::filesystem::path& result_folder,
                                  std::uint32_t first,
                                  const client::StagePerGlass& stage_per_glass);

}  // namespace intaglio::console
