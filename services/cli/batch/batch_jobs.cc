#include "services/cli/batch/batch_jobs.h"

#include <fmt/format.h>

#include <optional>
#include <set>

#include "engrave/core/try.h"
#include "materials_db/material_store.h"
#include "services/cli/job/job_glass.h"
#include "services/cli/job/job_options.h"
#include "services/cli/job/job_series.h"
#include "services/job/checks/job_check.h"
#include "services/job/fields/job_kind.h"
#include "services/job/files/batch_file.h"
#include "services/job/files/freeze.h"
#include "services/job/files/job_file.h"
#include "services/job/files/submission_id.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

class BatchBuilder {
 public:
  BatchBuilder(const BatchSource& source, materials_db::MaterialStore& materials)
      : source_(source),
        folder_(fs::absolute(source.file).parent_path()),
        materials_(materials) {}

  Status FindCells() {
    std::vector<Error> errors;
    for (const std::string& wanted : source_.cells) {
      auto cell = CellOf(wanted);
      if (!cell) {
        errors.push_back(Prefixed(cell.error(), "--cells: "));
      } else if (!cells_.emplace(cell->name, *cell).second) {
        errors.push_back({ErrorCode::kInvalidValue,
                          fmt::format("--cells: two profiles have the name '{}': give "
                                      "each machine a different name",
                                      cell->name),
                          cell->name});
      }
    }
    if (errors.empty()) return {};
    return tl::unexpected(JoinErrors(errors));
  }

  Result<BatchJob> Build(const BatchLine& line) {
    const auto pattern = INTAGLIO_TRY(Pattern(line.job_file));
    const auto spec = INTAGLIO_TRY(JobOf(line, pattern, folder_));
    const auto cells = INTAGLIO_TRY(CellsOf(line));
    BatchJob job;
    job.key = line.key;
    if (!line.key.empty()) {
      INTAGLIO_TRY(CheckSubmissionKey(line.key));
      if (!keys_.insert(line.key).second)
        return Fail(ErrorCode::kInvalidValue,
                    fmt::format("key '{}': another line has it already", line.key));
    }
    job.id = line.id;
    job.planned.priority = spec.priority();
    std::optional<Error> first;
    for (const std::optional<std::string>& machine : cells) {
      auto complete = Complete(spec, machine);
      if (!complete) {
        if (!first) first = complete.error();
        continue;
      }
      job.name = complete->job.name();
      job.warnings = complete->warnings;
      job.planned.cells.push_back(complete->machine.name());
      job.by_cell[complete->machine.name()] = std::move(complete->job);
    }
    // What fits one of the machines goes there.
    if (job.by_cell.empty()) return tl::unexpected(*first);
    return job;
  }

 private:
  struct Cell {
    std::string name, file;
  };

  static Result<Cell> CellOf(const std::string& wanted) {
    const auto file = INTAGLIO_TRY(FindMachineFile(wanted));
    const auto machine = INTAGLIO_TRY(ReadMachineFile(file));
    return Cell{machine.name(), file.string()};
  }

  /// Profiles to try; one without a file: the job's own.
  Result<std::vector<std::optional<std::string>>> CellsOf(const BatchLine& line) const {
    std::vector<std::optional<std::string>> files;
    if (!line.cell.empty()) {
      const auto known = cells_.find(line.cell);
      if (known != cells_.end()) return std::vector{std::optional(known->second.file)};
      const auto cell = CellOf(line.cell);
      if (!cell) return tl::unexpected(Prefixed(cell.error(), "cell: "));
      return std::vector{std::optional(cell->file)};
    }
    for (const auto& [name, cell] : cells_) files.emplace_back(cell.file);
    if (files.empty()) files.emplace_back();
    return files;
  }

  Result<JobSpec> Pattern(const std::string& job_file) {
    if (job_file.empty() && source_.job_file.empty()) {
      return Fail(ErrorCode::kMissing,
                  "job: is missing; name a job file here, or one for all with --job");
    }
    const std::string path = job_file.empty()
                                 ? source_.job_file
                                 : (folder_ / job_file).lexically_normal().string();
    const auto found = patterns_.find(path);
    if (found != patterns_.end()) return found->second;
    return patterns_.emplace(path, ReadJobFile(path)).first->second;
  }

  Result<JobAndMachine> Complete(const JobSpec& spec,
                                 const std::optional<std::string>& machine) {
    JobFlags flags;
    flags.job_file = source_.file.string();  // with a job file no value is chosen
                                             // automatically
    flags.machine = machine;
    auto complete = CompleteJob(flags, spec);
    if (!complete) return complete;
    if (MakesMarks(complete->job)) {
      INTAGLIO_TRY(FreezeMarkJob(complete->job, complete->machine, {}));
      return complete;
    }
    const auto material = INTAGLIO_TRY(FindGlass(*complete, materials_));
    INTAGLIO_TRY(FreezeJob(complete->job, complete->machine, material, {}));
    return complete;
  }

  const BatchSource& source_;
  fs::path folder_;
  materials_db::MaterialStore& materials_;
  std::map<std::string, Cell> cells_;
  std::set<std::string> keys_;
  std::map<std::string, Result<JobSpec>> patterns_;  // by path
};

}  // namespace

Result<std::vector<BatchJob>> BuildBatch(const BatchSource& source) {
  const auto lines = INTAGLIO_TRY(ReadBatchFile(source.file));
  auto materials = INTAGLIO_TRY(materials_db::MaterialStore::Open(source.materials_db));
  BatchBuilder builder(source, materials);
  INTAGLIO_TRY(builder.FindCells());
  std::vector<Error> errors;
  for (const Error& error : CheckBatchOrder(lines)) {
    errors.push_back(Prefixed(error, source.file.string() + ", "));
  }
  std::vector<BatchJob> jobs;
  std::map<std::string, std::size_t> place;
  for (const BatchLine& line : lines) {
    place.emplace(line.id, place.size());
    const std::string where = fmt::format("{}, line {} ({}): ", source.file.string(),
                                          line.line_number, line.id);
    auto job = builder.Build(line);
    if (!job) {
      errors.push_back(Prefixed(job.error(), where));
      continue;
    }
    for (Warning& warning : job->warnings) warning.text = where + warning.text;
    jobs.push_back(std::move(*job));
  }
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    for (const std::string& before : lines[i].after) {
      jobs[i].planned.after.push_back(place.at(before));
    }
  }
  return jobs;
}

}  // namespace intaglio::cli
