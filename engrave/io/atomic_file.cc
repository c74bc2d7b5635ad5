#include "engrave/io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

namespace intaglio::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferSize = 256 * 1024;
constexpr int kMaxNames = 10'000;

const char* RemedyFor(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return "free some space there or choose another folder";
    case ENOENT:
    case ENOTDIR:
      return "create the folder or choose another one";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder you may write to";
    case EFBIG:
      return "choose a file system that takes files of this size";
    default:
      return "check the disk or choose another folder";
  }
}

tl::unexpected<Error> Refused(const fs::path& target, int error_number) {
  return Fail(
      ErrorCode::kIo,
      fmt::format("{}: cannot be written ({}); {}", target.string(),
                  std::generic_category().message(error_number), RemedyFor(error_number)),
      target.string());
}

int OpenRetrying(const fs::path& path, int flags, mode_t mode = kUsualMode) {
  int descriptor = -1;
  do {
    descriptor = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  } while (descriptor < 0 && errno == EINTR);
  return descriptor;
}

bool IsWrittenDirectly(const fs::path& target) {
  std::error_code ignored;
  const fs::file_status status = fs::status(target, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// The file behind symbolic links, so that a link is not replaced by a file.
fs::path ResolveLinks(const fs::path& target) {
  std::error_code error;
  if (!fs::is_symlink(fs::symlink_status(target, error))) return target;
  const fs::path resolved = fs::weakly_canonical(target, error);
  return error ? target : resolved;
}

void SyncFolderOf(const fs::path& target) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const int descriptor = OpenRetrying(folder, O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) return;
  // A file system that cannot sync a folder has renamed all the same.
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

Result<AtomicFile> AtomicFile::Create(const fs::path& target, mode_t mode) {
  AtomicFile file;
  file.target_ = ResolveLinks(target);
  std::error_code ignored;
  if (target.filename().empty() || fs::is_directory(file.target_, ignored)) {
    return Refused(target, EISDIR);
  }
  if (IsWrittenDirectly(file.target_)) {
    file.descriptor_ = OpenRetrying(file.target_, O_WRONLY | O_NOCTTY);
  } else {
    for (int i = 0; i < kMaxNames && file.descriptor_ < 0; ++i) {
      file.temporary_ = file.target_;
      file.temporary_ += fmt::format(".{}.{}.part", ::getpid(), i);
      file.descriptor_ = OpenRetrying(file.temporary_, O_WRONLY | O_CREAT | O_EXCL, mode);
      if (file.descriptor_ < 0 && errno != EEXIST) break;
    }
  }
  if (file.descriptor_ < 0) {
    file.temporary_.clear();
    return Refused(target, errno);
  }
  file.buffer_.reserve(kBufferSize);
  return file;
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept { *this = std::move(other); }

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this != &other) {
    Abandon();
    target_ = std::move(other.target_);
    temporary_ = std::exchange(other.temporary_, {});
    descriptor_ = std::exchange(other.descriptor_, -1);
    buffer_ = std::move(other.buffer_);
  }
  return *this;
}

AtomicFile::~AtomicFile() { Abandon(); }

void AtomicFile::Abandon() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (!temporary_.empty()) {
    ::unlink(temporary_.c_str());
    temporary_.clear();
  }
}

Status AtomicFile::Write(std::span<const std::byte> bytes) {
  Require(descriptor_ >= 0, "{}: written after its end", target_.string());
  while (!bytes.empty()) {
    const std::size_t room = kBufferSize - buffer_.size();
    const auto piece = bytes.first(std::min(room, bytes.size()));
    buffer_.insert(buffer_.end(), piece.begin(), piece.end());
    bytes = bytes.subspan(piece.size());
    if (buffer_.size() < kBufferSize) continue;
    if (Status status = Flush(); !status) return status;
  }
  return {};
}

Status AtomicFile::Write(std::string_view text) {
  return Write(std::as_bytes(std::span(text.data(), text.size())));
}

Status AtomicFile::Flush() {
  std::span<const std::byte> rest = buffer_;
  while (!rest.empty()) {
    const ssize_t count = ::write(descriptor_, rest.data(), rest.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      const int error_number = errno;
      Abandon();
      return Refused(target_, error_number);
    }
    rest = rest.subspan(static_cast<std::size_t>(count));
  }
  buffer_.clear();
  return {};
}

Status AtomicFile::CloseDurably() {
  // A terminal or a pipe has no disk to sync to and returns EINVAL or ENOTSUP.
  const bool synced = ::fsync(descriptor_) == 0 || temporary_.empty();
  int error_number = synced ? 0 : errno;
  if (::close(std::exchange(descriptor_, -1)) != 0 && error_number == 0) {
    error_number = errno;
  }
  if (error_number == 0) return {};
  Abandon();
  return Refused(target_, error_number);
}

Status AtomicFile::Commit() {
  Require(descriptor_ >= 0, "{}: committed after its end", target_.string());
  INTAGLIO_TRY(Flush());
  INTAGLIO_TRY(CloseDurably());
  if (temporary_.empty()) return {};
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    const int error_number = errno;
    Abandon();
    return Refused(target_, error_number);
  }
  temporary_.clear();
  SyncFolderOf(target_);
  return {};
}

Status WriteFileAtomically(const fs::path& target, std::span<const std::byte> bytes,
                           mode_t mode) {
  AtomicFile file = INTAGLIO_TRY(AtomicFile::Create(target, mode));
  INTAGLIO_TRY(file.Write(bytes));
  return file.Commit();
}

Status WriteFileAtomically(const fs::path& target, std::string_view text, mode_t mode) {
  return WriteFileAtomically(target, std::as_bytes(std::span(text.data(), text.size())),
                             mode);
}

}  // namespace intaglio::io
