#include "services/platform/recording/append_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <utility>
#include <vector>

#include "engrave/io/crc32.h"
#include "services/platform/recording/mcap_records.h"

namespace intaglio::recording {
namespace {

tl::unexpected<Error> Refused(const std::filesystem::path& path, const char* what) {
  const int reason = errno;
  const char* remedy = reason == ENOSPC || reason == EDQUOT
                           ? "free space, or record to another disk"
                           : "check the folder, the permissions and the disk";
  const bool no_folder = reason == ENOENT || reason == ENOTDIR;
  return Fail(no_folder ? ErrorCode::kNotFound : ErrorCode::kIo,
              fmt::format("cannot {} the recording {}: {}; {}", what, path.string(),
                          std::strerror(reason), remedy),
              path.string());
}

/// writev until everything is written; false with errno otherwise.
bool WriteAll(int descriptor, std::vector<iovec>& pieces) {
  std::size_t first = 0;
  while (first < pieces.size()) {
    if (pieces[first].iov_len == 0) {
      ++first;
      continue;
    }
    const ssize_t written = writev(descriptor, pieces.data() + first,
                                   static_cast<int>(pieces.size() - first));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    auto left = static_cast<std::size_t>(written);
    while (first < pieces.size() && left >= pieces[first].iov_len) {
      left -= pieces[first++].iov_len;
    }
    if (left > 0) {
      pieces[first].iov_base = static_cast<char*>(pieces[first].iov_base) + left;
      pieces[first].iov_len -= left;
    }
  }
  return true;
}

/// A file is found again after a power failure when its folder is on the disk, too.
bool KeepName(const std::filesystem::path& path) {
  const auto parent = path.parent_path();
  const int folder =
      open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return false;
  // Some file systems know no such thing for folders, and need none.
  const bool kept = fsync(folder) == 0 || errno == EINVAL;
  const int reason = errno;
  close(folder);
  errno = reason;
  return kept;
}

}  // namespace

Result<AppendFile> AppendFile::Create(const std::filesystem::path& path,
                                      Existing existing) {
  const int when_there = existing == Existing::kKeep ? O_EXCL : O_TRUNC;
  const int descriptor =
      open(path.c_str(), O_WRONLY | O_CREAT | when_there | O_CLOEXEC, 0666);
  if (descriptor < 0 && errno == EEXIST) {
    return Fail(ErrorCode::kRefused,
                fmt::format("{} already exists; use another name", path.string()),
                path.string());
  }
  if (descriptor < 0) return Refused(path, "make");
  AppendFile made(descriptor, path);
  if (!KeepName(path)) {
    auto refused = Refused(path, "make");
    if (existing == Existing::kKeep) (void)unlink(path.c_str());
    return refused;
  }
  return made;
}

AppendFile::AppendFile(int descriptor, std::filesystem::path path)
    : descriptor_(descriptor), path_(std::move(path)) {}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      path_(std::move(other.path_)),
      size_(other.size_),
      synced_size_(other.synced_size_),
      crc_(other.crc_) {}

AppendFile& AppendFile::operator=(AppendFile&& other) noexcept {
  if (this == &other) return *this;
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = std::exchange(other.descriptor_, -1);
  path_ = std::move(other.path_);
  size_ = other.size_;
  synced_size_ = other.synced_size_;
  crc_ = other.crc_;
  return *this;
}

AppendFile::~AppendFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

Status AppendFile::Append(std::initializer_list<ByteView> pieces) {
  std::vector<iovec> vectors;
  std::uint64_t total = 0;
  for (const ByteView piece : pieces) {
    vectors.push_back({const_cast<std::byte*>(piece.data()), piece.size()});
    total += piece.size();
  }
  if (!WriteAll(descriptor_, vectors)) {
    auto refused = Refused(path_, "write");
    // A torn record in mid-file would end every reading there.
    if (ftruncate(descriptor_, static_cast<off_t>(size_)) == 0) {
      (void)lseek(descriptor_, static_cast<off_t>(size_), SEEK_SET);
    }
    return refused;
  }
  for (const ByteView piece : pieces) crc_ = io::Crc32(piece, crc_);
  size_ += total;
  return {};
}

Status AppendFile::Sync() {
  if (fdatasync(descriptor_) != 0) return Refused(path_, "keep");
  synced_size_ = size_;
  return {};
}

}  // namespace intaglio::recording
