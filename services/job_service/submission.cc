#include "services/job_service/submission.h"

#include <fmt/format.h>
#include <google/protobuf/unknown_field_set.h>

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

// A field of a newer client would be left out of the job without a word.
std::optional<std::string> UnknownField(const google::protobuf::Message& message,
                                        const std::string& path) {
  const google::protobuf::Reflection& fields = *message.GetReflection();
  if (const auto& unknown = fields.GetUnknownFields(message); !unknown.empty())
    return fmt::format("{} has a field with number {}", path, unknown.field(0).number());
  std::vector<const google::protobuf::FieldDescriptor*> set;
  fields.ListFields(message, &set);
  for (const auto* field : set) {
    if (field->cpp_type() != field->CPPTYPE_MESSAGE) continue;
    const int count = field->is_repeated() ? fields.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const auto& part = field->is_repeated()
                             ? fields.GetRepeatedMessage(message, field, i)
                             : fields.GetMessage(message, field);
      if (auto found = UnknownField(part, path + "." + field->name())) return found;
    }
  }
  return std::nullopt;
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
  if (const auto unknown = UnknownField(job, "job")) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} that this job service (version {}) does not know: use a "
                            "client of the same version",
                            *unknown, software_version));
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
