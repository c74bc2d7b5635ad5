#include "services/console/submit/submissions.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <system_error>

#include "engrave/core/try.h"
#include "engrave/drawing/font_list.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/crc32.h"
#include "engrave/io/whole_file.h"
#include "proto/shop.pb.h"
#include "services/client/exit_codes.h"
#include "services/console/answers/json_response.h"
#include "services/console/submit/program_run.h"
#include "services/job/convert/model_kind.h"
#include "services/job/files/job_file.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

/// Longer than `intaglio submit` waits for a job service, and reads a large model.
constexpr std::chrono::seconds kSubmitTime{90};
constexpr std::uint64_t kMaxNoteBytes = 255;

Status CheckFile(const std::string& file, const std::string& field,
                 const fs::path& folder) {
  if (auto name = CheckUploadName(file); !name) {
    return Fail(name.error().code, fmt::format("{}: {}", field, name.error().message),
                file);
  }
  std::error_code error;
  if (fs::is_regular_file(fs::symlink_status(folder / file, error))) return {};
  return Fail(ErrorCode::kNotFound,
              fmt::format("{}: {} was not sent whole for this submission: send it first, "
                          "then the job file",
                          field, file),
              file);
}

bool IsFontFamily(const std::string& file, const std::string& field) {
  return field.find(".text.") != std::string::npos && !drawing::IsFontFile(file);
}

bool IsProfileOf(const std::vector<ShopMachine>& shop, const std::string& file) {
  return std::ranges::any_of(shop, [&](const ShopMachine& machine) {
    return !file.empty() && machine.profile == file;
  });
}

int StatusOfExit(int exit_code) {
  return exit_code == client::kExitWrongInput ? 422 : 503;
}

int StatusOfRun(const Error& error) {
  return error.code == ErrorCode::kTimedOut ? 504 : 503;
}

}  // namespace

bool IsJson(const std::string& job_file) {
  const auto first = job_file.find_first_not_of(" \t\r\n");
  return first != std::string::npos && job_file[first] == '{';
}

Status CheckFilesOfSubmission(JobSpec job, const fs::path& folder,
                              const std::vector<ShopMachine>& shop) {
  Status status;
  ForEachFile(job, [&](const std::string& file, const std::string& field) {
    if (status && !IsFontFamily(file, field)) status = CheckFile(file, field, folder);
  });
  const std::string& profile = job.machine_file();
  if (status && !IsNameOfAProfile(profile, folder) && !IsProfileOf(shop, profile))
    return CheckFile(profile, "machine_file", folder);
  return status;
}

Result<fs::path> Submissions::Write(const std::string& id,
                                    const std::string& job_file) const {
  const fs::path folder = INTAGLIO_TRY(uploads_.FolderOf(id));
  const bool is_json = IsJson(job_file);
  auto job = INTAGLIO_TRY(ParseJob(
      job_file, is_json ? JobFileFormat::kJson : JobFileFormat::kText, "job file"));
  INTAGLIO_TRY(CheckFilesOfSubmission(std::move(job), folder, machines_()));
  std::error_code error;
  fs::create_directories(folder, error);
  // By its bytes: another job with the same id, which is refused, replaces nothing.
  const fs::path file =
      folder / fmt::format(".job-{:08x}.{}",
                           io::Crc32(std::as_bytes(std::span(job_file))),
                           is_json ? "json" : "textproto");
  INTAGLIO_TRY(io::WriteFileAtomically(file, std::string_view(job_file)));
  return file;
}

Result<fs::path> Submissions::WriteOnce(const std::string& id,
                                        const Writer& writer) const {
  // The name of an upload does not begin with '.'.
  const fs::path folder = INTAGLIO_TRY(uploads_.FolderOf(id)) / ".written";
  const fs::path note = folder / "job_file";
  if (const auto name = io::ReadWholeFile(note, kMaxNoteBytes)) return folder / *name;
  const fs::path file = INTAGLIO_TRY(writer(folder));
  INTAGLIO_TRY(io::WriteFileAtomically(note, std::string_view(file.filename().string())));
  return file;
}

SubmissionAnswer Submissions::Submit(const std::string& id,
                                     const std::string& job_file) const {
  return SubmitFile(id, Write(id, job_file));
}

SubmissionAnswer Submissions::SubmitWritten(const std::string& id,
                                            const Writer& writer) const {
  return SubmitFile(id, WriteOnce(id, writer));
}

SubmissionAnswer Submissions::SubmitFile(const std::string& id,
                                         const Result<fs::path>& file) const {
  SubmissionAnswer submission;
  submission.answer.set_id(id);
  const auto fail = [&submission](int status, const ConsoleError& refusal) {
    submission.status = status;
    submission.answer.set_message(refusal.message());
    submission.answer.set_code(refusal.code());
    return submission;
  };
  if (!file) return fail(422, ErrorOf(file.error()));
  std::vector<std::string> words = {"submit", file->string(), "--id", id, "--events"};
  words.insert(words.end(), shop_arguments_.begin(), shop_arguments_.end());
  const auto end = RunIntaglio(std::move(words), file->parent_path(), kSubmitTime);
  if (!end) return fail(StatusOfRun(end.error()), ErrorOf(end.error()));
  google::protobuf::util::JsonParseOptions lenient;
  lenient.ignore_unknown_fields = true;
  for (const std::string& line : end->json) {
    JobEvent event;
    const auto read = google::protobuf::util::JsonStringToMessage(line, &event, lenient);
    if (!read.ok() || event.event() != "submitted") continue;
    submission.answer.set_submitted(true);
    submission.answer.set_job(event.job());
    submission.answer.set_uid(event.uid());
    submission.answer.set_state(event.state());
  }
  if (!submission.answer.submitted())
    return fail(StatusOfExit(end->exit_code), RefusalOf(*end));
  return submission;
}

PreviewAnswer Submissions::Preview(const std::string& id,
                                   const std::string& job_file) const {
  const auto file = Write(id, job_file);
  if (!file) return {422, {}, ErrorOf(file.error())};
  const fs::path folder = file->parent_path();
  std::vector<std::string> words = {"preview", file->string(), "--json", "--out",
                                    (folder / kPreviewFolder).string()};
  if (!materials_.empty()) words.insert(words.end(), {"--materials", materials_});
  std::error_code ignored;
  for (const char* picture : kPreviewPictures) fs::remove(folder / picture, ignored);
  const auto end = RunIntaglio(std::move(words), folder, kSubmitTime);
  if (!end) return {StatusOfRun(end.error()), {}, ErrorOf(end.error())};
  JobPreview preview;
  const bool made =
      !end->json.empty() &&
      google::protobuf::util::JsonStringToMessage(end->json.front(), &preview).ok();
  if (made) return {200, std::move(preview), {}};
  return {StatusOfExit(end->exit_code), {}, RefusalOf(*end)};
}

}  // namespace intaglio::console
