#include "services/cell/begun_job.h"

#include <google/protobuf/util/json_util.h>

#include <string>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"

namespace intaglio::cell {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t kMaxBytes = 256u << 20;

}  // namespace

Status WriteBegunJob(const fs::path& folder, const FrozenJob& job) {
  std::string json;
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  (void)google::protobuf::util::MessageToJsonString(job, &json, options);
  return io::WriteFileAtomically(folder / kJobFile, json);
}

Result<std::optional<FrozenJob>> ReadBegunJob(const fs::path& folder) {
  const fs::path file = folder / kJobFile;
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  const std::string json = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxBytes));
  FrozenJob job;
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  if (google::protobuf::util::JsonStringToMessage(json, &job, options).ok()) return job;
  return Fail(ErrorCode::kUnreadable,
              file.string() +
                  " cannot be read, but the job was begun: nobody knows with which zero; "
                  "check the piece, cancel the job, and make it again on a new one",
              file.string());
}

}  // namespace intaglio::cell
