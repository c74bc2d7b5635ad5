#include "services/job/files/job_file.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include "engrave/core/try.h"
#include "engrave/drawing/font_list.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/whole_file.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/model_kind.h"
#include "services/job/files/json_position.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_defaults.h"
#include "services/platform/text_format/field_suggestion.h"
#include "services/platform/text_format/text_format.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;

// The messages nest five deep.
constexpr int kMaxDepth = 16;

Status ParseJson(std::string_view text, const std::string& name, pb::Message& message) {
  INTAGLIO_TRY(CheckTextCode(text, name));
  text = io::WithoutByteOrderMark(text);
  const auto status = pb::util::JsonStringToMessage({text.data(), text.size()}, &message);
  if (status.ok()) return {};
  const std::string what(status.message());
  return Fail(ErrorCode::kUnreadable,
              fmt::format("{}:{}{}", name, LocateJsonError(text, what),
                          SuggestionFor(*message.GetDescriptor(), what)));
}

Status Parse(std::string_view text, JobFileFormat format, const std::string& name,
             pb::Message& message) {
  if (text.size() > kMaxJobFileBytes) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{}: is larger than {} bytes; is it a job file?", name,
                            kMaxJobFileBytes));
  }
  return format == JobFileFormat::kJson ? ParseJson(text, name, message)
                                        : ParseTextFormat(text, name, kMaxDepth, message);
}

Result<JobFileFormat> FormatOf(const fs::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".textproto" || ending == ".txtpb") return JobFileFormat::kText;
  if (ending == ".json") return JobFileFormat::kJson;
  return Fail(ErrorCode::kUnsupported,
              fmt::format("{}: the extension has to be .textproto, .txtpb or .json",
                          path.string()),
              ending);
}

Status ReadMessage(const fs::path& path, pb::Message& message) {
  const auto format = INTAGLIO_TRY(FormatOf(path));
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(path, kMaxJobFileBytes));
  return Parse(text, format, path.string(), message);
}

void MakeAbsolute(std::string& file, const fs::path& folder) {
  if (!file.empty()) file = (folder / file).lexically_normal().string();
}

/// Families become the files that this machine has for them; one that is not found stays,
/// and the check reports it.
void NameFontFile(std::string& font) {
  if (font.empty() || drawing::IsFontFile(font)) return;
  if (auto file = drawing::FindFontFile(font)) font = std::move(*file);
}

bool IsFont(const std::string& path) { return path.find(".text.") != std::string::npos; }

}  // namespace

Result<JobSpec> ParseJob(std::string_view text, JobFileFormat format,
                         const std::string& name) {
  JobSpec job;
  INTAGLIO_TRY(Parse(text, format, name, job));
  return job;
}

Result<MachineSpec> ParseMachine(std::string_view text, JobFileFormat format,
                                 const std::string& name) {
  MachineSpec machine;
  INTAGLIO_TRY(Parse(text, format, name, machine));
  return machine;
}

Result<JobSpec> ReadJobFile(const fs::path& path) {
  JobSpec job;
  INTAGLIO_TRY(ReadMessage(path, job));
  ResolveFiles(job, fs::absolute(path).parent_path());
  return job;
}

bool IsNameOfAProfile(const std::string& machine_file, const fs::path& folder) {
  if (machine_file.empty()) return true;
  std::error_code ignored;
  const fs::path path(machine_file);
  return !path.has_parent_path() && !path.has_extension() &&
         !fs::exists(folder / path, ignored);
}

void ResolveFiles(JobSpec& job, const fs::path& folder) {
  ForEachFile(job, [&](std::string& file, const std::string& path) {
    if (IsFont(path)) {
      NameFontFile(file);
      if (!drawing::IsFontFile(file)) return;  // a family that is not installed
    }
    MakeAbsolute(file, folder);
  });
  if (!IsNameOfAProfile(job.machine_file(), folder)) {
    MakeAbsolute(*job.mutable_machine_file(), folder);
  }
}

Result<MachineSpec> ReadUncheckedMachine(const fs::path& path) {
  MachineSpec machine;
  INTAGLIO_TRY(ReadMessage(path, machine));
  if (machine.has_head_over_block()) {
    MakeAbsolute(*machine.mutable_head_over_block()->mutable_correction_file(),
                 fs::absolute(path).parent_path());
  }
  return machine;
}

Result<MachineSpec> ReadMachineFile(const fs::path& path) {
  MachineSpec machine = INTAGLIO_TRY(ReadUncheckedMachine(path));
  if (const auto errors = CheckMachine(machine); !errors.empty()) {
    Error all = JoinErrors(errors);
    all.message = fmt::format("{}:\n{}", path.string(), all.message);
    return tl::unexpected(all);
  }
  INTAGLIO_TRY(TakeCorrectionFile(machine));
  return WithMachineDefaults(machine);
}

namespace {

/// In the format that the name says.
Status WriteMessage(const fs::path& path, const pb::Message& message) {
  const auto format = INTAGLIO_TRY(FormatOf(path));
  std::string text;
  if (format == JobFileFormat::kJson) {
    pb::util::JsonPrintOptions options;
    options.add_whitespace = true;
    options.preserve_proto_field_names = true;
    const auto status = pb::util::MessageToJsonString(message, &text, options);
    if (!status.ok())
      return Fail(ErrorCode::kInvalidValue, std::string(status.message()));
  } else {
    pb::TextFormat::PrintToString(message, &text);
  }
  return io::WriteFileAtomically(path, std::string_view(text));
}

}  // namespace

Status WriteMachineFile(const fs::path& path, const MachineSpec& machine) {
  if (machine.head_over_block().correction_file().empty())
    return WriteMessage(path, machine);
  MachineSpec with_path = machine;  // who reads it reads the corrections' file again
  with_path.mutable_head_over_block()->clear_correction_table();
  return WriteMessage(path, with_path);
}

Status WriteJobFile(const fs::path& path, const JobSpec& job) {
  return WriteMessage(path, job);
}

}  // namespace intaglio
