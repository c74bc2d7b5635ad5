// The part of JobClient that submits jobs.

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <random>

#include "engrave/core/try.h"
#include "services/client/job_client.h"
#include "services/job/files/submission_id.h"
#include "services/platform/bus/samples.h"

namespace intaglio::client {
namespace {

using bus::Borrow;

std::int64_t SteadyNs() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}

/// The same bytes for the same job.
std::vector<std::uint8_t> BytesOf(const JobSpec& job) {
  std::vector<std::uint8_t> bytes(job.ByteSizeLong());
  google::protobuf::io::ArrayOutputStream array(bytes.data(),
                                                static_cast<int>(bytes.size()));
  google::protobuf::io::CodedOutputStream out(&array);
  out.SetSerializationDeterministic(true);
  job.SerializeToCodedStream(&out);
  return bytes;
}

}  // namespace

std::string NewSubmissionKey() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

Error JobClient::WhyNoAnswer(const std::string& key, double waited_s) const {
  for (const auto& [instance, service] : services_) {
    if (service.role != intaglio_ROLE_JOB_SERVICE) continue;
    return {ErrorCode::kFault,
            fmt::format("{} did not answer the submission within {:.0f} s: it is not "
                        "known whether it took the job. Check its log and its disk "
                        "(intaglio status); the same command with --id {} then gets the "
                        "answer, and submits nothing twice",
                        instance, waited_s, key),
            instance};
  }
  return {ErrorCode::kTimedOut, kNoJobService, ""};
}

Result<JobView> JobClient::Submit(const JobSpec& job, std::chrono::milliseconds timeout,
                                  std::string key) {
  if (!submissions_) return Fail(ErrorCode::kRefused, no_submissions_);
  if (key.empty()) key = NewSubmissionKey();
  INTAGLIO_TRY(CheckSubmissionKey(key));
  const std::vector<std::uint8_t> bytes = BytesOf(job);
  const std::string uid = SubmissionUid(key, bytes);
  const std::string client = OperatorName();
  intaglio_JobSubmission sample{};
  sample.submission_uid = Borrow(uid);
  sample.client = Borrow(client);
  Borrow(sample.job, bytes);
  sample.steady_ns = SteadyNs();
  INTAGLIO_TRY(submissions_->Write(sample));
  const JobView* found = nullptr;
  const auto answered = [&] {
    if (refused_.contains(uid)) return true;
    for (const auto& [job_uid, view] : jobs_) {
      if (view.submission_uid == uid) found = &view;
    }
    return found != nullptr;
  };
  const auto began = Clock::now();
  const Result<bool> answer = AwaitAnswer(answered, timeout);
  const std::chrono::duration<double> waited = Clock::now() - began;
  // The job service that answered has stored it; one that has not read it does not.
  (void)submissions_->Dispose(sample);
  if (!answer) return tl::unexpected(answer.error());
  if (!*answer) return tl::unexpected(WhyNoAnswer(key, waited.count()));
  if (found == nullptr) return Fail(ErrorCode::kRefused, refused_[uid].message);
  return *found;
}

}  // namespace intaglio::client
