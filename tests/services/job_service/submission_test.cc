#include "services/job_service/submission.h"

#include <gmock/gmock.h>
#include <google/protobuf/unknown_field_set.h>

#include <vector>

namespace intaglio::job_service {
namespace {

using testing::HasSubstr;

std::vector<std::uint8_t> Bytes(const JobSpec& job) {
  std::vector<std::uint8_t> bytes(job.ByteSizeLong());
  job.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

std::string RefusalOf(const JobSpec& job) {
  const FindMaterial none = [](const std::string& name) {
    return Result<materials_db::Material>(Fail(ErrorCode::kNotFound, "no " + name));
  };
  const auto frozen = FreezeSubmission(Bytes(job), none, "0.1.0");
  return frozen ? "" : frozen.error().message;
}

void AddUnknown(google::protobuf::Message& message) {
  message.GetReflection()->MutableUnknownFields(&message)->AddVarint(6001, 1);
}

TEST(Submission, AFieldOfANewerClientIsNotLeftOut) {
  JobSpec job;
  AddUnknown(job);
  EXPECT_EQ(RefusalOf(job),
            "job has a field with number 6001 that this job service (version 0.1.0) does "
            "not know: use a client of the same version");
}

TEST(Submission, AFieldInAPartOfTheJobIsFound) {
  JobSpec job;
  job.mutable_models()->Add();
  AddUnknown(*job.mutable_models()->Add());
  EXPECT_THAT(RefusalOf(job), HasSubstr("job.models has a field with number 6001"));
}

}  // namespace
}  // namespace intaglio::job_service
