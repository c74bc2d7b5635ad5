#include "services/console/submit/upload_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/job/files/submission_id.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxNameBytes = 200;
/// Left to the shop, which needs room for its own files.
constexpr std::uint64_t kFreeBytes = std::uint64_t{1} << 30;
constexpr auto kPartTime = std::chrono::hours(24);
constexpr char kPart[] = ".part";

tl::unexpected<Error> RefusedBySystem(const fs::path& file) {
  return Fail(ErrorCode::kIo,
              fmt::format("{}: {}: free some room on the console's disk, or check its "
                          "rights",
                          file.filename().string(), std::strerror(errno)),
              file.string());
}

fs::path PartOf(const fs::path& folder, const std::string& file,
                std::uint64_t size_bytes) {
  return folder / fmt::format(".{}.{}{}", file, size_bytes, kPart);
}

UploadAnswer AnswerOf(const std::string& file, std::uint64_t received,
                      std::uint64_t size) {
  UploadAnswer answer;
  answer.set_file(file);
  answer.set_received_bytes(static_cast<std::uint32_t>(received));
  answer.set_size_bytes(static_cast<std::uint32_t>(size));
  answer.set_complete(received == size);
  return answer;
}

/// The size in the name of a part of this file; nullopt: it is another's.
std::optional<std::uint64_t> SizeInName(const std::string& name,
                                        const std::string& file) {
  const std::string begin = fmt::format(".{}.", file);
  if (!name.starts_with(begin) || !name.ends_with(kPart)) return std::nullopt;
  const std::string digits = name.substr(
      begin.size(), name.size() - std::min(name.size(), begin.size() + sizeof kPart - 1));
  const bool is_number = !digits.empty() && digits.size() < 19 &&
                         std::all_of(digits.begin(), digits.end(),
                                     [](char c) { return c >= '0' && c <= '9'; });
  return is_number ? std::optional(std::stoull(digits)) : std::nullopt;
}

/// There is room for another file of this submission.
Status CheckRoom(const fs::path& folder, const fs::path& part, std::uint64_t bytes) {
  std::error_code error;
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder, error))
    count += entry.path() != part && entry.is_regular_file() ? 1 : 0;
  if (count >= kMaxUploadsOfAJob) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("a submission has at most {} files", kMaxUploadsOfAJob));
  }
  const auto space = fs::space(folder, error);
  if (!error && space.available >= bytes + kFreeBytes) return {};
  return Fail(
      ErrorCode::kIo,
      "the console's disk has less than 1 GB left for such a file: free some room");
}

}  // namespace

Status CheckUploadName(std::string_view name) {
  const bool good = !name.empty() && name.size() <= kMaxNameBytes &&
                    name.front() != '.' &&
                    std::none_of(name.begin(), name.end(), [](unsigned char c) {
                      return c < 0x20 || c == 0x7f || c == '/' || c == '\\';
                    });
  if (good) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("file '{}': give the name of a file without folders, 1 to {} "
                          "bytes, that does not begin with '.'",
                          name, kMaxNameBytes),
              std::string(name));
}

OpenUpload::~OpenUpload() {
  if (descriptor_ >= 0) close(descriptor_);
}

Status OpenUpload::Compare(std::string_view bytes) {
  std::string there(bytes.size(), '\0');
  const ssize_t count =
      pread(descriptor_, there.data(), there.size(), static_cast<off_t>(received_bytes_));
  if (count < 0) return RefusedBySystem(file_);
  if (static_cast<std::size_t>(count) == bytes.size() && there == bytes) return {};
  return Fail(ErrorCode::kRefused,
              fmt::format("{} was sent before with other bytes, and a job may be made "
                          "from it: give the submission a new id",
                          file_.filename().string()));
}

Status OpenUpload::Write(std::string_view bytes) {
  if (bytes.size() > size_bytes_ - received_bytes_)
    return Fail(ErrorCode::kTooLarge, "more bytes came than were announced");
  if (is_whole_) {
    INTAGLIO_TRY(Compare(bytes));
    received_bytes_ += bytes.size();
    return {};
  }
  while (!bytes.empty()) {
    const ssize_t count = pwrite(descriptor_, bytes.data(), bytes.size(),
                                 static_cast<off_t>(received_bytes_));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return RefusedBySystem(file_);
    received_bytes_ += static_cast<std::uint64_t>(count);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

Result<UploadAnswer> OpenUpload::Close() {
  if (!is_whole_ && received_bytes_ == size_bytes_) {
    std::error_code error;
    if (fsync(descriptor_) != 0) return RefusedBySystem(file_);
    fs::rename(part_, file_, error);
    if (error) return Fail(ErrorCode::kIo, error.message(), file_.string());
  }
  return AnswerOf(file_.filename().string(), received_bytes_, size_bytes_);
}

Result<fs::path> UploadFolder::FolderOf(const std::string& id) const {
  if (root_.empty()) {
    return Fail(ErrorCode::kMissing,
                "this console takes no files: start it with --uploads FOLDER");
  }
  INTAGLIO_TRY(CheckSubmissionKey(id));
  if (id.front() == '.')
    return Fail(ErrorCode::kInvalidValue, "submission id: begins with '.'", id);
  return root_ / id;
}

Result<UploadAnswer> UploadFolder::Find(const std::string& id,
                                        const std::string& file) const {
  const fs::path folder = INTAGLIO_TRY(FolderOf(id));
  INTAGLIO_TRY(CheckUploadName(file));
  std::error_code error;
  if (const auto size = fs::file_size(folder / file, error); !error)
    return AnswerOf(file, size, size);
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const auto size = SizeInName(entry.path().filename().string(), file);
    if (!size) continue;
    if (const auto there = entry.file_size(error); !error)
      return AnswerOf(file, there, *size);
  }
  return Fail(ErrorCode::kNotFound, fmt::format("nothing of {} has come", file), file);
}

Result<std::unique_ptr<OpenUpload>> UploadFolder::Open(const std::string& id,
                                                       const std::string& file,
                                                       std::uint64_t offset_bytes,
                                                       std::uint64_t size_bytes) const {
  const fs::path folder = INTAGLIO_TRY(FolderOf(id));
  INTAGLIO_TRY(CheckUploadName(file));
  if (size_bytes > kMaxUploadBytes || offset_bytes > size_bytes) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{}: offset {} of {} bytes: a file has at most {} bytes",
                            file, offset_bytes, size_bytes, kMaxUploadBytes));
  }
  std::error_code error;
  fs::create_directories(folder, error);
  std::unique_ptr<OpenUpload> upload(new OpenUpload);
  upload->file_ = folder / file;
  upload->part_ = PartOf(folder, file, size_bytes);
  upload->size_bytes_ = size_bytes;
  upload->received_bytes_ = offset_bytes;
  upload->is_whole_ = fs::exists(upload->file_, error);
  if (upload->is_whole_) {
    upload->descriptor_ = open(upload->file_.c_str(), O_RDONLY | O_CLOEXEC);
    if (upload->descriptor_ < 0) return RefusedBySystem(upload->file_);
    if (fs::file_size(upload->file_, error) == size_bytes) return upload;
    return Fail(ErrorCode::kRefused,
                fmt::format("{} was sent before with another size, and a job may be made "
                            "from it: give the submission a new id",
                            file));
  }
  INTAGLIO_TRY(CheckRoom(folder, upload->part_, size_bytes - offset_bytes));
  upload->descriptor_ =
      open(upload->part_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (upload->descriptor_ < 0) return RefusedBySystem(upload->file_);
  if (flock(upload->descriptor_, LOCK_EX | LOCK_NB) != 0) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{} is being sent by another connection: wait for it", file));
  }
  struct stat there {};
  if (fstat(upload->descriptor_, &there) != 0) return RefusedBySystem(upload->file_);
  const auto end = static_cast<std::uint64_t>(there.st_size);
  if (offset_bytes > 0 && offset_bytes != end) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{}: {} {} come: go on at offset={}", file,
                            Counted(end, "byte"), HasOrHave(end), end));
  }
  if (ftruncate(upload->descriptor_, static_cast<off_t>(offset_bytes)) != 0)
    return RefusedBySystem(upload->file_);
  return upload;
}

void UploadFolder::RemoveOld() const {
  std::error_code error;
  const auto now = fs::file_time_type::clock::now();
  for (const auto& submission : fs::directory_iterator(root_, error)) {
    for (const auto& entry : fs::directory_iterator(submission.path(), error)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with('.') || !name.ends_with(kPart)) continue;
      const auto written = entry.last_write_time(error);
      if (!error && now - written > kPartTime) fs::remove(entry.path(), error);
    }
  }
}

}  // namespace intaglio::console
