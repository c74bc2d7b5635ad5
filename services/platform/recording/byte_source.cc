#include "services/platform/recording/byte_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace intaglio::recording {
namespace {

class FileSource final : public ByteSource {
 public:
  FileSource(int descriptor, std::uint64_t size, std::string name)
      : descriptor_(descriptor), size_(size), name_(std::move(name)) {}
  ~FileSource() override { close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::uint64_t size() const override { return size_; }
  const std::string& name() const override { return name_; }

  Status Read(std::uint64_t offset, std::span<std::byte> out) const override {
    while (!out.empty()) {
      const ssize_t count =
          pread(descriptor_, out.data(), out.size(), static_cast<off_t>(offset));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        return Fail(ErrorCode::kIo,
                    fmt::format("{}: cannot read at byte {}: {}; check the disk, and "
                                "whether the file was truncated",
                                name_, offset,
                                count < 0 ? std::strerror(errno) : "the file ends"),
                    name_);
      }
      offset += static_cast<std::uint64_t>(count);
      out = out.subspan(static_cast<std::size_t>(count));
    }
    return {};
  }

 private:
  int descriptor_;
  std::uint64_t size_;
  std::string name_;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> OpenFileSource(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (descriptor < 0 || fstat(descriptor, &status) != 0) {
    const int reason = errno;
    if (descriptor >= 0) close(descriptor);
    return Fail(reason == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
                fmt::format("cannot open the recording {}: {}", file.string(),
                            std::strerror(reason)),
                file.string());
  }
  auto source = std::make_unique<FileSource>(
      descriptor, static_cast<std::uint64_t>(status.st_size), file.string());
  if (!S_ISREG(status.st_mode)) {
    return Fail(ErrorCode::kIo,
                fmt::format("{} is not a file; a recording is one", file.string()),
                file.string());
  }
  return source;
}

}  // namespace intaglio::recording
