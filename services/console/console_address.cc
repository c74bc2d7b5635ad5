#include "services/console/console_address.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"

namespace intaglio::console {
namespace {

constexpr std::string_view kBegin = "http://127.0.0.1:";
constexpr std::string_view kKeyBegin = "/?key=";
constexpr std::size_t kKeyDigits = 64;
constexpr std::uint64_t kMaxFileBytes = 4096;

bool IsHex(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); }

Error WriteError(const std::filesystem::path& file) {
  return {ErrorCode::kIo,
          fmt::format("cannot write {}: {}", file.string(), std::strerror(errno)),
          file.string()};
}

}  // namespace

std::string NewKey() {
  std::array<unsigned char, kKeyDigits / 2> bytes{};
  Require(getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
          "getrandom failed with errno {}", errno);
  std::string key;
  for (const unsigned char byte : bytes) key += fmt::format("{:02x}", byte);
  return key;
}

std::string TextOf(const ConsoleAddress& address) {
  return fmt::format("{}{}{}{}", kBegin, address.port, kKeyBegin, address.key);
}

Result<ConsoleAddress> ParseAddress(const std::string& text) {
  ConsoleAddress address;
  const auto wrong = [&] {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("no address of a console: '{}'", text.substr(0, 100)));
  };
  if (!text.starts_with(kBegin)) return wrong();
  const char* end = text.data() + text.size();
  const auto [read, error] =
      std::from_chars(text.data() + kBegin.size(), end, address.port);
  const std::string_view rest(read, static_cast<std::size_t>(end - read));
  if (error != std::errc() || address.port == 0 || !rest.starts_with(kKeyBegin))
    return wrong();
  address.key = rest.substr(kKeyBegin.size());
  if (address.key.size() != kKeyDigits ||
      !std::all_of(address.key.begin(), address.key.end(), IsHex))
    return wrong();
  return address;
}

Result<ConsoleAddress> ReadAddressFile(const std::filesystem::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxFileBytes));
  return ParseAddress(text.substr(0, text.find('\n')));
}

Status WriteAddressFile(const std::filesystem::path& file,
                        const ConsoleAddress& address) {
  const std::string temporary = fmt::format("{}.{}", file.string(), getpid());
  unlink(temporary.c_str());
  const int descriptor =
      open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) return tl::unexpected(WriteError(file));
  const std::string line = TextOf(address) + "\n";
  const bool written =
      write(descriptor, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  close(descriptor);
  if (!written || rename(temporary.c_str(), file.c_str()) != 0) {
    auto error = WriteError(file);
    unlink(temporary.c_str());
    return tl::unexpected(std::move(error));
  }
  return {};
}

}  // namespace intaglio::console
