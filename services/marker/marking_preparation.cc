#include "services/marker/marking_preparation.h"

#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>

#include <filesystem>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/mark/mark_file.h"
#include "services/cell/begun_job.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/machine/machine_defaults.h"
#include "services/job/marks/web_run.h"

namespace intaglio::marker {
namespace {

namespace fs = std::filesystem;

Result<mark::MarkSet> MarksOf(const fs::path& folder,
                              std::optional<mark::MarkSet> marks) {
  if (marks) return std::move(*marks);
  const fs::path file = folder / kMarksFile;
  if (fs::exists(file)) return mark::ReadMarkFile(file);
  return Fail(ErrorCode::kNotFound,
              file.string() +
                  " is not there, but the job was begun: see that the folder "
                  "of its results is mounted, and check the piece",
              file.string());
}

drivers::PrintEye PrintEyeOf(const Marks& marks) {
  const MarkEye& eye = marks.web().eye();
  return {.pitch_mm = marks.repeats().pitch_mm(),
          .offset_mm = eye.offset_mm(),
          .tolerance_mm = eye.tolerance_mm(),
          .max_missing = eye.max_missing()};
}

Status WritePlanOf(const fs::path& folder, const FrozenJob& job,
                   const mark::MarkSet& marks) {
  INTAGLIO_TRY(mark::WriteMarkFile(folder / kMarksFile, marks));
  return cell::WriteBegunJob(folder, job);
}

}  // namespace

Result<PreparedMarking> PrepareMarking(const FrozenJob& job,
                                       std::optional<mark::MarkSet> marks,
                                       const ProgressSink& progress) {
  const fs::path folder = job.result_directory();
  const bool on_disk = !marks.has_value();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Fail(ErrorCode::kIo, fmt::format("cannot make the result directory {}: {}",
                                            folder.string(), error.message()));
  }
  PreparedMarking prepared;
  prepared.job.uid = job.job_uid();
  prepared.job.asks_when_uncertain = job.job().when_uncertain() == UNCERTAIN_POINTS_ASK;
  prepared.job.marks = INTAGLIO_TRY(MarksOf(folder, std::move(marks)));
  if (prepared.job.marks.marks.empty())
    return Fail(ErrorCode::kInvalidValue, "the job has no marks: nothing to make");
  if (job.job().has_marks() && job.job().marks().has_web()) {
    prepared.job.max_web_mm_s =
        INTAGLIO_TRY(WebRunOf(job.job(), job.machine(), prepared.job.marks)).max_mm_s;
  }
  if (job.job().marks().web().has_eye()) {
    prepared.job.eye = PrintEyeOf(WithDefaults(job.job().marks()));
  }
  if (!progress(1, 2))
    return Fail(ErrorCode::kCancelled, "the job was cancelled during its preparation");
  auto opened = INTAGLIO_TRY(cell::OpenJournal(
      folder / kJournalFile,
      {prepared.job.marks.marks.size(), job.epoch(), mark::MarksCrc(prepared.job.marks)},
      on_disk ? cell::JobBegun::kItsPathIsThere : cell::JobBegun::kNo));
  if (!on_disk) INTAGLIO_TRY(WritePlanOf(folder, job, prepared.job.marks));
  prepared.job.earlier = std::move(opened.earlier);
  prepared.journal = std::move(opened.writer);
  return prepared;
}

Status CheckMarkTask(const FrozenJob& job, const MachineSpec& machine) {
  google::protobuf::util::MessageDifferencer differencer;
  std::string differences;
  differencer.ReportDifferencesToString(&differences);
  differencer.IgnoreField(MachineSpec::descriptor()->FindFieldByName("mark_line"));
  const MachineSpec own = WithMachineDefaults(machine);
  if (!differencer.Compare(WithMachineDefaults(job.machine()), own)) {
    return Fail(ErrorCode::kRefused,
                fmt::format("the profile of the job differs from that of this machine, "
                            "{}: {}; submit it again with the profile of this cell",
                            own.name(), differences));
  }
  std::vector<Finding> errors = CheckAll(job.job(), own);
  // The files were read where the marks were made.
  std::erase_if(errors, [](const Finding& found) { return found.field != "machine"; });
  if (errors.empty()) return {};
  return tl::unexpected(JoinErrors(errors));
}

}  // namespace intaglio::marker
