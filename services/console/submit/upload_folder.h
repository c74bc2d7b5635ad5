#pragma once

// Files of jobs that are submitted over HTTP: a folder for each submission, by its id,
// with the files that its job names. A file is there whole or not at all: what has come
// of it so far lies beside it as ".NAME.SIZE.part", and the next request goes on there.
//
// A file that is whole never changes, because a job may be made from it: the same bytes
// again are fine, others are refused.
//
// Not to be called from several threads at once.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "proto/console.pb.h"

namespace intaglio::console {

/// As the programs read at most (services/job/models/read_limits.h).
inline constexpr std::uint64_t kMaxUploadBytes = std::uint64_t{1} << 30;
inline constexpr std::size_t kMaxUploadsOfAJob = 64;

/// kInvalidValue unless it is the name of a file alone: 1 to 200 bytes, no '/', no
/// control character, no '.' at its begin.
Status CheckUploadName(std::string_view name);

/// A file while its bytes come.
class OpenUpload {
 public:
  OpenUpload(const OpenUpload&) = delete;
  OpenUpload& operator=(const OpenUpload&) = delete;
  ~OpenUpload();
  /// kIo: the disk refuses it. kRefused: another file of this name is there.
  Status Write(std::string_view bytes);
  /// The file is whole when everything of it has come.
  Result<UploadAnswer> Close();

 private:
  friend class UploadFolder;
  OpenUpload() = default;
  Status Compare(std::string_view bytes);
  std::filesystem::path file_, part_;
  std::uint64_t received_bytes_ = 0, size_bytes_ = 0;
  bool is_whole_ = false;  ///< it is compared with the file that is there
  int descriptor_ = -1;
};

class UploadFolder {
 public:
  explicit UploadFolder(std::filesystem::path root) : root_(std::move(root)) {}

  /// The folder of a submission. kInvalidValue: its id is none; kMissing: uploads are not
  /// taken.
  Result<std::filesystem::path> FolderOf(const std::string& id) const;
  /// How much of it has come. kNotFound: nothing.
  Result<UploadAnswer> Find(const std::string& id, const std::string& file) const;
  /// Goes on at `offset_bytes`, where the file so far ends, or begins again at 0.
  /// kInvalidValue, kTooLarge, kIo; kRefused: `offset_bytes` is not where it ends, or
  /// another connection sends it.
  Result<std::unique_ptr<OpenUpload>> Open(const std::string& id, const std::string& file,
                                           std::uint64_t offset_bytes,
                                           std::uint64_t size_bytes) const;
  /// Parts that nothing was added to for a day.
  void RemoveOld() const;

 private:
  std::filesystem::path root_;  ///< empty: uploads are not taken
};

}  // namespace intaglio::console
