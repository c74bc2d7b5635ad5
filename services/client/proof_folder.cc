#include "services/client/proof_folder.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "engrave/core/try.h"
#include "engrave/formats/glass_record.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/atomic_file.h"
#include "services/client/proof/glass_search.h"
#include "services/client/proof/known_outcome.h"
#include "services/client/proof/proof_figures.h"
#include "services/client/proof/proof_pictures.h"
#include "services/client/proof_verdict.h"
#include "services/job/json_text.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGlassFile = "glass.ply";

Status WriteGlass(const std::vector<formats::GlassCrack>& cracks, const fs::path& file) {
  formats::PointTable table;
  std::vector<double> tick;
  std::vector<std::uint8_t> channel, station;
  for (const formats::GlassCrack& crack : cracks) {
    if (!crack.in_glass) continue;
    table.points_mm.push_back(crack.position_mm);
    tick.push_back(static_cast<double>(crack.tick));
    channel.push_back(static_cast<std::uint8_t>(crack.channel));
    station.push_back(crack.station);
  }
  table.comments = {
      "cracks as recorded by the virtual engraver's glass, glass frame, mm"};
  table.columns = {{"tick", std::move(tick)},
                   {"channel", std::move(channel)},
                   {"station", std::move(station)}};
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

/// The cracks of the job, from the records of the engraver; nothing where they are not
/// known.
Status CompleteGlass(const FolderToComplete& which) {
  const fs::path file = which.folder / kGlassFile;
  if (!which.renew && fs::exists(file)) return {};
  const auto journal = INTAGLIO_TRY(formats::ReadJournal(which.folder / "journal.bin"));
  const fs::path shop = fs::absolute(which.folder).lexically_normal();
  const fs::path parent =
      (shop.has_filename() ? shop : shop.parent_path()).parent_path().parent_path();
  const auto cracks = INTAGLIO_TRY(
      FindCracks(journal, which.glass_folder.empty() ? parent : which.glass_folder));
  return cracks ? WriteGlass(*cracks, file) : Status();
}

Status WriteMissing(const FolderToComplete& which, const ProvedFolder& proved) {
  const auto needs = [&](const char* file) {
    return which.renew || !fs::exists(which.folder / file);
  };
  if (needs(kViewsFile)) {
    INTAGLIO_TRY(WriteViews(which.folder, proved.evidence, proved.report));
  }
  // Last: a folder with a report is complete.
  return needs(kReportFile) ? WriteReport(which.folder, proved.report) : Status();
}

}  // namespace

std::string UtcNow() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

Result<JobReport> MakeProof(const ProofInputs& inputs) {
  for (const char* file : {"path.ply", "job.json", "journal.bin"}) {
    INTAGLIO_TRY(CopyInto(inputs.job_folder / file, inputs.folder / file));
  }
  const auto record = INTAGLIO_TRY(formats::ReadGlassRecord(inputs.glass_record));
  INTAGLIO_TRY(WriteGlass(record.cracks, inputs.folder / kGlassFile));
  const auto evidence = INTAGLIO_TRY(ReadEvidence(inputs.folder));
  JobReport report = FiguresOf(evidence);
  AddStages(StagesOf(inputs), report);
  Judge(report);
  INTAGLIO_TRY(WriteViews(inputs.folder, evidence, report));
  INTAGLIO_TRY(WriteReport(inputs.folder, report));
  return report;
}

Result<ProvedFolder> VerifyFolder(const fs::path& folder) {
  ProvedFolder proved;
  auto evidence = INTAGLIO_TRY(ReadEvidence(folder));
  proved.evidence = std::move(evidence);
  proved.report = FiguresOf(proved.evidence);
  AddKnown(folder, proved.report);
  Judge(proved.report);
  return proved;
}

Result<ProvedFolder> CompleteFolder(const FolderToComplete& which) {
  if (IsOpen(which.folder)) return VerifyFolder(which.folder);
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
