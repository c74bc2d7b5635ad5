#include "engrave/io/whole_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::io {
namespace {

class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OpenFile(OpenFile&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenFile& operator=(OpenFile&&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// False: the file ended before, or an error.
bool ReadAll(int descriptor, std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = read(descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}

tl::unexpected<Error> Refuse(const std::filesystem::path& file, ErrorCode code,
                             std::string_view problem_and_remedy) {
  return Fail(code, fmt::format("{}: {}", file.string(), problem_and_remedy),
              file.string());
}

/// An open regular file.
struct Source {
  OpenFile in;
  std::uint64_t size = 0;
};

// The kind of the file is checked before it is opened, because opening some devices acts
// on them, and again afterwards, because the path may name another file by then. It is
// opened without waiting (O_NONBLOCK), because opening a FIFO would wait.
Result<Source> OpenSource(const std::filesystem::path& file) {
  struct stat status = {};
  if (stat(file.c_str(), &status) != 0 && (errno == ENOENT || errno == ENOTDIR)) {
    return Refuse(file, ErrorCode::kNotFound,
                  "the file does not exist; check its name and folder");
  }
  constexpr std::string_view kNoFile = "this is not a file; name a file";
  if (status.st_mode != 0 && !S_ISREG(status.st_mode)) {
    return Refuse(file, ErrorCode::kIo, kNoFile);
  }
  const int descriptor = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  Source source{OpenFile(descriptor)};
  if (descriptor < 0 || fstat(descriptor, &status) != 0) {
    return Refuse(file, ErrorCode::kIo, "cannot be opened; check that you may read it");
  }
  if (!S_ISREG(status.st_mode)) return Refuse(file, ErrorCode::kIo, kNoFile);
  source.size = static_cast<std::uint64_t>(status.st_size);
  return source;
}

Status CheckSize(const std::filesystem::path& file, const Source& source,
                 std::uint64_t max_bytes) {
  if (source.size <= max_bytes) return {};
  return Refuse(file, ErrorCode::kTooLarge,
                fmt::format("has {} bytes, more than the {} allowed; make it smaller or "
                            "raise the limit",
                            source.size, max_bytes));
}

Result<std::string> ReadBytes(const std::filesystem::path& file, const Source& source,
                              std::uint64_t count) {
  std::string bytes(count, '\0');
  if (ReadAll(source.in.descriptor(), bytes)) return bytes;
  return Refuse(file, ErrorCode::kIo, "cannot be read to its end; check the disk");
}

}  // namespace

Result<std::string> ReadWholeFile(const std::filesystem::path& file,
                                  std::uint64_t max_bytes) {
  const auto source = INTAGLIO_TRY(OpenSource(file));
  INTAGLIO_TRY(CheckSize(file, source, max_bytes));
  return ReadBytes(file, source, source.size);
}

Status ReadInPieces(const std::filesystem::path& file, std::uint64_t max_bytes,
                    std::size_t piece_bytes,
                    const std::function<Status(std::span<const std::byte> piece,
                                               std::uint64_t size)>& take) {
  const auto source = INTAGLIO_TRY(OpenSource(file));
  INTAGLIO_TRY(CheckSize(file, source, max_bytes));
  std::uint64_t left = source.size;
  do {
    const std::uint64_t count = std::min<std::uint64_t>(left, piece_bytes);
    const std::string piece = INTAGLIO_TRY(ReadBytes(file, source, count));
    if (Status taken = take(std::as_bytes(std::span(piece)), source.size); !taken)
      return tl::unexpected(AboutFile(std::move(taken.error()), file));
    left -= count;
  } while (left > 0);
  return {};
}

Result<std::string> ReadBeginning(const std::filesystem::path& file,
                                  std::uint64_t count) {
  const auto source = INTAGLIO_TRY(OpenSource(file));
  return ReadBytes(file, source, std::min(count, source.size));
}

Error AboutFile(Error error, const std::filesystem::path& file) {
  error.message = file.string() + ": " + error.message;
  if (error.value.empty()) error.value = file.string();
  return error;
}

}  // namespace intaglio::io
