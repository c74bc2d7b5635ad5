#include "services/client/proof/known_outcome.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/proof_folder.h"
#include "services/client/proof/proof_verdict.h"
#include "services/job/verdict/verdict.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxBytes = 64u << 20;

/// Fields of newer programs are ignored.
template <typename Message>
Result<Message> ReadJson(const fs::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxBytes));
  Message message;
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  const auto parsed =
      google::protobuf::util::JsonStringToMessage(text, &message, options);
  if (!parsed.ok()) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: {}", file.string(), parsed.ToString()), file.string());
  }
  return message;
}

void AddOfReport(const JobReport& known, JobReport& report) {
  if (known.has_discretize()) *report.mutable_discretize() = known.discretize();
  if (known.has_sort()) *report.mutable_sort() = known.sort();
  if (known.has_engrave()) *report.mutable_engrave() = known.engrave();
  report.set_job_number(known.job_number());
  report.set_started_utc(known.started_utc());
  report.set_ended_utc(known.ended_utc());
  report.set_wall_time_s(known.wall_time_s());
  if (report.estimated_time_s() == 0)
    report.set_estimated_time_s(known.estimated_time_s());
  if (report.machining_time_s() == 0)
    report.set_machining_time_s(known.machining_time_s());
  const auto plan = known.checksums().find("plan");
  if (plan != known.checksums().end())
    (*report.mutable_checksums())["plan"] = plan->second;
}

void AddStatistics(const JobStatistics& statistics, JobReport& report) {
  report.set_job_number(statistics.job());
  report.set_started_utc(statistics.started_utc());
  report.set_ended_utc(statistics.ended_utc());
  report.set_wall_time_s(statistics.duration_s());
  if (report.estimated_time_s() == 0)
    report.set_estimated_time_s(statistics.estimated_s());
  if (report.warnings().empty()) *report.mutable_warnings() = statistics.warnings();
  if (report.breakage_accepted_by().empty())
    report.set_breakage_accepted_by(statistics.breakage_accepted_by());
}

}  // namespace

void AddStages(const JobStages& stages, JobReport& report) {
  if (stages.has_discretize())
    *report.mutable_discretize() = stages.discretize().discretize();
  if (stages.has_sort()) *report.mutable_sort() = stages.sort().sort();
  if (stages.has_engrave()) {
    *report.mutable_engrave() = stages.engrave().engrave();
    // A journal of marks has no times of them.
    if (report.has_marks() && report.machining_time_s() == 0)
      report.set_machining_time_s(stages.engrave().elapsed_s());
  }
  if (stages.has_engrave() && !report.has_marks()) {
    report.set_estimated_time_s(static_cast<double>(report.engrave().estimate_ticks()) /
                                report.job().laser().rate_hz());
    (*report.mutable_checksums())["plan"] = report.engrave().plan_checksum();
  }
  report.set_job_number(stages.job_number());
  report.set_started_utc(stages.started_utc());
  report.set_ended_utc(stages.ended_utc());
  report.set_wall_time_s(stages.wall_time_s());
  *report.mutable_warnings() = stages.warnings();
  report.set_breakage_accepted_by(stages.breakage_accepted_by());
}

void AddKnown(const fs::path& folder, JobReport& report) {
  std::error_code error;
  if (fs::exists(folder / kReportFile, error)) {
    // Warnings of older versions have another form, of which only they are readable.
    if (const auto known = ReadJson<JobReport>(folder / kReportFile))
      AddOfReport(*known, report);
    AddWarningsOf(folder / kReportFile, report);
    return;
  }
  if (const auto stages = ReadJson<JobStages>(folder / kStagesFile))
    AddStages(*stages, report);
  if (const auto statistics = ReadStatistics(folder)) AddStatistics(*statistics, report);
}

bool AddLostProof(const fs::path& folder, JobReport& report) {
  if (report.evidence() != kControllerEvidence) return false;
  const auto known = ReadJson<JobReport>(folder / kReportFile);
  if (!known || known->evidence().empty() || known->evidence() == kControllerEvidence)
    return false;
  Verdict& verdict = *report.mutable_verdict();
  const auto name = [](VerdictKind kind) { return std::string(VerdictName(kind)); };
  const Verdict& before = known->verdict();
  if (!before.good() && before.kind() != name(VerdictKind::kGoodWithWarnings)) {
    verdict.set_kind(name(VerdictKind::kNotGood));
    for (const std::string& reason : before.reasons()) verdict.add_reasons(reason);
  } else if (verdict.good()) {
    verdict.set_kind(name(VerdictKind::kGoodWithWarnings));
  }
  verdict.set_good(false);
  verdict.add_reasons(fmt::format(
      "{0} was proved by the {1}, whose record is not in the folder any more, so that "
      "only the controller's counters are known now: put the record back and verify the "
      "folder again",
      kReportFile, known->evidence() == kGlassEvidence ? "glass" : "piece"));
  return true;
}

Result<JobStatistics> ReadStatistics(const fs::path& folder) {
  return ReadJson<JobStatistics>(folder / "statistics.json");
}

bool IsOpen(const fs::path& folder) {
  const auto statistics = ReadStatistics(folder);
  return statistics && statistics->state() != "done" && statistics->state() != "failed" &&
         statistics->state() != "cancelled";
}

}  // namespace intaglio::client
