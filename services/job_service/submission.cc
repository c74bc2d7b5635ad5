#include "services/job_service/submission.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "services/job/checks/job_check.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/job_kind.h"
#include "services/job/files/freeze.h"
#include "services/job/files/job_file.h"

namespace intaglio::job_service {
namespace {

// A relative path would be resolved in the folder of the process that reads it.
void RequireAbsolute(const std::string& path, const std::string& field,
                     std::vector<Error>& errors) {
  if (path.empty() || std::filesystem::path(path).is_absolute()) return;
  errors.push_back({ErrorCode::kInvalidValue,
                    fmt::format("{}: {} has to be an absolute path", field, path), path});
}

std::vector<Error> CheckPaths(JobSpec& job) {
  std::vector<Error> errors;
  RequireAbsolute(job.machine_file(), "machine_file", errors);
  ForEachFile(job, [&](const std::string& file, const std::string& field) {
    RequireAbsolute(file, field, errors);
  });
  return errors;
}

template <typename T>
std::optional<T> TakeOr(Result<T> result, const std::string& field,
                        std::vector<Error>& errors) {
  if (result) return std::move(*result);
  Error error = std::move(result.error());
  error.message = fmt::format("{}: {}", field, error.message);
  errors.push_back(std::move(error));
  return {};
}

}  // namespace

Result<FrozenJob> FreezeSubmission(std::span<const std::uint8_t> job_bytes,
                                   const FindMaterial& find_material,
                                   const std::string& software_version) {
  JobSpec job;
  if (job_bytes.size() > kMaxJobFileBytes ||
      !job.ParseFromArray(job_bytes.data(), static_cast<int>(job_bytes.size()))) {
    return Fail(ErrorCode::kUnreadable,
                "the submission contains no job: use a client of the same version");
  }
  if (const auto errors = CheckPaths(job); !errors.empty()) {
    return tl::unexpected(JoinErrors(errors));
  }
  std::vector<Error> missing;
  std::optional<MachineSpec> machine;
  if (!job.machine_file().empty()) {
    machine = TakeOr(ReadMachineFile(job.machine_file()), "machine_file", missing);
  }
  if (machine && ConcernsMarks(job, *machine))
    return FreezeMarkJob(job, *machine, {"", 0, "", software_version});
  std::optional<materials_db::Material> material;
  if (!job.glass().empty())
    material = TakeOr(find_material(job.glass()), "glass", missing);
  if (machine && material)
    return FreezeJob(job, *machine, *material, {"", 0, "", software_version});
  std::vector<Finding> errors = machine ? CheckAll(job, *machine) : CheckJob(job);
  errors.insert(errors.end(), missing.begin(), missing.end());
  return tl::unexpected(JoinErrors(errors));
}

}  // namespace intaglio::job_service
