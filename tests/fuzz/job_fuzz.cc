// Any bytes as a job file: refused with a message, or checked, completed and written
// again without a crash. What is written reads back the same.

#include <google/protobuf/text_format.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  for (const JobFileFormat format : {JobFileFormat::kText, JobFileFormat::kJson}) {
    const auto job = ParseJob(text, format, "fuzz");
    if (!job && job.error().message.empty()) std::abort();
    const MachineSpec machine =
        ParseMachine(text, format, "fuzz").value_or(MachineSpec());
    if (!job) continue;
    (void)CheckAll(*job, machine, 0.65);
    const JobSpec whole = WithDefaults(*job, machine);
    std::string written;
    if (!google::protobuf::TextFormat::PrintToString(whole, &written)) continue;
    if (written.size() <= kMaxJobFileBytes &&
        !ParseJob(written, JobFileFormat::kText, "fuzz")) {
      std::abort();
    }
  }
  return 0;
}
