#include "services/platform/access/secret_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "engrave/core/check.h"

namespace intaglio::access {
namespace {

Error WriteError(const std::filesystem::path& file) {
  return {ErrorCode::kIo,
          fmt::format("cannot write {}: {}", file.string(), std::strerror(errno)),
          file.string()};
}

}  // namespace

std::string NewKey() {
  std::array<unsigned char, 32> bytes{};
  Require(getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
          "getrandom failed with errno {}", errno);
  std::string key;
  for (const unsigned char byte : bytes) key += fmt::format("{:02x}", byte);
  return key;
}

Status WriteSecretFile(const std::filesystem::path& file, const std::string& text) {
  const std::string temporary = fmt::format("{}.{}", file.string(), getpid());
  unlink(temporary.c_str());
  const int descriptor =
      open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) return tl::unexpected(WriteError(file));
  const bool written =
      write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
      fsync(descriptor) == 0;
  close(descriptor);
  if (!written || rename(temporary.c_str(), file.c_str()) != 0) {
    auto error = WriteError(file);
    unlink(temporary.c_str());
    return tl::unexpected(std::move(error));
  }
  return {};
}

}  // namespace intaglio::access
