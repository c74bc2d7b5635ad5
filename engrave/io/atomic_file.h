#pragma once

// Files that exist completely or not at all: the data are written to a temporary file
// beside the target, which is renamed to the target only when everything is on the disk.
// A reader of the target sees the old content or the new one, never a part.
//
// The file has mode 0666 less the umask, or the mode that is given: a secret (0600) is at
// no time readable by others, also not in the temporary file.
//
// A target that exists and is not a regular file (a terminal, a pipe, /dev/null) cannot
// be replaced by a rename and is written directly. A symbolic link stays: the file it
// names is replaced.
//
// Errors, ErrorCode::kIo: a sentence with the path, what the system refused (a full disk,
// a missing folder, no permission) and the remedy. A failed or abandoned write leaves the
// target unchanged and removes the temporary file.
//
// Not to be called from several threads at once on one object; several objects are fine,
// even of one target (the last to commit wins).

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::io {

/// Readable by everybody whom the umask leaves, and by the owner alone.
inline constexpr mode_t kUsualMode = 0666, kSecretMode = 0600;

/// Writes a file piece by piece, through a buffer of 256 KiB.
class AtomicFile {
 public:
  /// Creates the temporary file, in the target's folder (which must exist).
  static Result<AtomicFile> Create(const std::filesystem::path& target,
                                   mode_t mode = kUsualMode);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();  // abandons what was not committed

  Status Write(std::span<const std::byte> bytes);
  Status Write(std::string_view text);

  /// Writes the rest, makes it durable (fsync of file and folder) and gives it its name.
  /// Write() and Commit() may not be called afterwards, nor after an error.
  Status Commit();

 private:
  AtomicFile() = default;
  Status Flush();
  Status CloseDurably();
  void Abandon() noexcept;

  std::filesystem::path target_;
  std::filesystem::path temporary_;  // empty when the target is written directly
  int descriptor_ = -1;
  std::vector<std::byte> buffer_;
};

Status WriteFileAtomically(const std::filesystem::path& target,
                           std::span<const std::byte> bytes, mode_t mode = kUsualMode);
Status WriteFileAtomically(const std::filesystem::path& target, std::string_view text,
                           mode_t mode = kUsualMode);

}  // namespace intaglio::io
