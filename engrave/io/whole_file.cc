#include "engrave/io/whole_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace intaglio::io {
namespace {

class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
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

}  // namespace

// The kind of the file is checked before it is opened, because opening some devices acts
// on them, and again afterwards, because the path may name another file by then. It is
// opened without waiting (O_NONBLOCK), because opening a FIFO would wait.
Result<std::string> ReadWholeFile(const std::filesystem::path& file,
                                  std::uint64_t max_bytes) {
  const auto refuse = [&](ErrorCode code, std::string_view problem_and_remedy) {
    return Fail(code, fmt::format("{}: {}", file.string(), problem_and_remedy),
                file.string());
  };
  struct stat status = {};
  if (stat(file.c_str(), &status) != 0 && (errno == ENOENT || errno == ENOTDIR)) {
    return refuse(ErrorCode::kNotFound,
                  "the file does not exist; check its name and folder");
  }
  constexpr std::string_view kNoFile = "this is not a file; name a file";
  if (status.st_mode != 0 && !S_ISREG(status.st_mode)) {
    return refuse(ErrorCode::kIo, kNoFile);
  }
  const OpenFile in(open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (in.descriptor() < 0 || fstat(in.descriptor(), &status) != 0) {
    return refuse(ErrorCode::kIo, "cannot be opened; check that you may read it");
  }
  if (!S_ISREG(status.st_mode)) return refuse(ErrorCode::kIo, kNoFile);
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > max_bytes) {
    return refuse(
        ErrorCode::kTooLarge,
        fmt::format("has {} bytes, more than the {} allowed; make it smaller or "
                    "raise the limit",
                    size, max_bytes));
  }
  std::string bytes(size, '\0');
  if (!ReadAll(in.descriptor(), bytes)) {
    return refuse(ErrorCode::kIo, "cannot be read to its end; check the disk");
  }
  return bytes;
}

Error AboutFile(Error error, const std::filesystem::path& file) {
  error.message = file.string() + ": " + error.message;
  if (error.value.empty()) error.value = file.string();
  return error;
}

}  // namespace intaglio::io
