#include "services/client/proof/proof_folder.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/atomic_file.h"
#include "services/client/proof/evidence/collisions.h"
#include "services/client/proof/evidence/glass_search.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/evidence/proof_pictures.h"
#include "services/client/proof/known_outcome.h"
#include "services/client/proof/marks/mark_figures.h"
#include "services/client/proof/marks/mark_pictures.h"
#include "services/client/proof/marks/mark_search.h"
#include "services/client/proof/proof_verdict.h"
#include "services/job/files/json_text.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGlassFile = "glass.ply";

/// glass.ply, and beside it what the head ran into.
Status WriteGlass(JobGlass glass, const fs::path& file) {
  INTAGLIO_TRY(WriteCollisions(glass.collisions, file.parent_path()));
  formats::PointTable table;
  table.points_mm = std::move(glass.cracks_mm);
  table.comments = {
      "cracks as recorded by the virtual engraver's glass, glass frame, mm"};
  // Not by a list of initial values, which would copy them.
  table.columns.push_back({"tick", std::move(glass.ticks)});
  table.columns.push_back({"channel", std::move(glass.channels)});
  table.columns.push_back({"station", std::move(glass.stations)});
  return formats::WritePly(file, table);
}

Status CopyInto(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (!error) return {};
  return Fail(
      ErrorCode::kIo,
      fmt::format(
          "cannot copy {} to {}: {}; free space on the disk or choose another --out",
          from.string(), to.string(), error.message()),
      to.string());
}

Status WriteReport(const fs::path& folder, const JobReport& report) {
  const auto json = INTAGLIO_TRY(JsonOf(report));
  return io::WriteFileAtomically(folder / kReportFile, json);
}

JobStages StagesOf(const ProofInputs& inputs) {
  JobStages stages;
  if (inputs.discretize) *stages.mutable_discretize() = *inputs.discretize;
  if (inputs.sort) *stages.mutable_sort() = *inputs.sort;
  if (inputs.engrave) *stages.mutable_engrave() = *inputs.engrave;
  stages.set_job_number(inputs.job_number);
  stages.set_started_utc(inputs.started_utc);
  stages.set_ended_utc(inputs.ended_utc);
  stages.set_wall_time_s(inputs.wall_time_s);
  AddTo(*stages.mutable_warnings(), inputs.warnings);
  stages.set_breakage_accepted_by(inputs.breakage_accepted_by);
  return stages;
}

/// With the records of the machine.
fs::path RecordFolderOf(const FolderToComplete& which) {
  if (!which.glass_folder.empty()) return which.glass_folder;
  const fs::path shop = fs::absolute(which.folder).lexically_normal();
  return (shop.has_filename() ? shop : shop.parent_path()).parent_path().parent_path();
}

/// The cracks of the job, or what was burnt for it, from the records of the engraver;
/// nothing where they are not known.
Status CompleteGlass(const FolderToComplete& which) {
  const bool marks = HasMarks(which.folder);
  const fs::path file = which.folder / (marks ? kBurntFile : kGlassFile);
  if (!which.renew && fs::exists(file)) return {};
  const fs::path journal_file = which.folder / "journal.bin";
  const fs::path records = RecordFolderOf(which);
  if (marks) {
    const auto journal = INTAGLIO_TRY(formats::ReadJournal(journal_file));
    const auto job = INTAGLIO_TRY(ReadFrozenJob(which.folder / "job.json"));
    const std::string& number = job.machine().mark_line().serial_number();
    const auto burnt = INTAGLIO_TRY(FindBurnt(journal, MarkRecordsIn(records, number)));
    return burnt ? formats::WriteMarkRecord(file, *burnt) : Status();
  }
  const auto spans = INTAGLIO_TRY(ReadTickSpans(journal_file));
  auto glass = INTAGLIO_TRY(FindGlass(spans, records));
  return glass ? WriteGlass(*std::move(glass), file) : Status();
}

Status WriteViewsOf(const fs::path& folder, const ProvedFolder& proved) {
  return std::visit(
      [&](const auto& evidence) { return WriteViews(folder, evidence, proved.report); },
      proved.evidence);
}

/// Its evidence and its figures.
Result<ProvedFolder> ReadFolder(const fs::path& folder) {
  ProvedFolder proved;
  if (HasMarks(folder)) {
    proved.evidence = INTAGLIO_TRY(ReadMarkEvidence(folder));
  } else {
    proved.evidence = INTAGLIO_TRY(ReadEvidence(folder));
  }
  proved.report =
      std::visit([](auto& evidence) { return FiguresOf(evidence); }, proved.evidence);
  return proved;
}

Status WriteMissing(const FolderToComplete& which, const ProvedFolder& proved) {
  if (which.renew && proved.lost_proof) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{} and the pictures are not renewed, because they were made "
                            "with a record that is not there any more",
                            kReportFile),
                which.folder.string());
  }
  const auto needs = [&](const char* file) {
    return which.renew || !fs::exists(which.folder / file);
  };
  if (needs(kViewsFile)) {
    INTAGLIO_TRY(WriteViewsOf(which.folder, proved));
  }
  // Last: a folder with a report is complete.
  return needs(kReportFile) ? WriteReport(which.folder, proved.report) : Status();
}

}  // namespace

std::string UtcNow() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

bool HasPlan(const fs::path& folder) {
  std::error_code error;
  return HasMarks(folder) || fs::exists(folder / "path.ply", error);
}

Result<JobReport> MakeProof(const ProofInputs& inputs) {
  const bool marks = HasMarks(inputs.job_folder);
  for (const char* file : {marks ? kMarksFile : "path.ply", "job.json", "journal.bin"}) {
    INTAGLIO_TRY(CopyInto(inputs.job_folder / file, inputs.folder / file));
  }
  if (inputs.glass_record.filename() == kCutRecord) {
    INTAGLIO_TRY(CopyInto(inputs.glass_record, inputs.folder / kCutFile));
  } else if (marks) {
    const auto journal =
        INTAGLIO_TRY(formats::ReadJournal(inputs.folder / "journal.bin"));
    INTAGLIO_TRY(
        formats::WriteMarkRecord(inputs.folder / kBurntFile,
                                 INTAGLIO_TRY(AllBurnt(journal, inputs.glass_record))));
  } else {
    auto glass = INTAGLIO_TRY(AllGlass(inputs.glass_record));
    INTAGLIO_TRY(WriteGlass(std::move(glass), inputs.folder / kGlassFile));
  }
  ProvedFolder proved = INTAGLIO_TRY(ReadFolder(inputs.folder));
  AddStages(StagesOf(inputs), proved.report);
  Judge(proved.report);
  INTAGLIO_TRY(WriteViewsOf(inputs.folder, proved));
  INTAGLIO_TRY(WriteReport(inputs.folder, proved.report));
  return proved.report;
}

Result<ProvedFolder> VerifyFolder(const fs::path& folder) {
  ProvedFolder proved = INTAGLIO_TRY(ReadFolder(folder));
  AddKnown(folder, proved.report);
  Judge(proved.report);
  proved.lost_proof = AddLostProof(folder, proved.report);
  return proved;
}

Result<ProvedFolder> CompleteFolder(const FolderToComplete& which) {
  if (IsOpen(which.folder)) {
    auto proved = VerifyFolder(which.folder);
    if (proved && !proved->report.verdict().good()) {
      proved->report.mutable_verdict()->add_reasons(
          "the job has not ended: what is still to be made counts as skipped");
    }
    return proved;
  }
  const auto glass = CompleteGlass(which);
  auto proved = INTAGLIO_TRY(VerifyFolder(which.folder));
  const auto written = glass ? WriteMissing(which, proved) : glass;
  if (!written) proved.not_written = written.error();
  return proved;
}

std::vector<fs::path> JobFoldersIn(const fs::path& folder) {
  std::vector<fs::path> jobs;
  std::error_code error;
  if (fs::exists(folder / "job.json", error)) return jobs;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (fs::exists(entry.path() / "journal.bin", error)) jobs.push_back(entry.path());
  }
  std::sort(jobs.begin(), jobs.end());
  return jobs;
}

Result<std::string> JsonOf(const JobReport& report) {
  auto json = JsonTextOf(report);
  if (!json) return Fail(json.error().code, "report.json: " + json.error().message);
  return json;
}

}  // namespace intaglio::client
