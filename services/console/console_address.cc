#include "services/console/console_address.h"

#include <fmt/format.h>

#include <charconv>
#include <regex>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"

namespace intaglio::console {
namespace {

constexpr char kKeyBegin[] = "?key=";
constexpr std::size_t kMaxAddressBytes = 400;
constexpr std::uint64_t kMaxFileBytes = 4096;

}  // namespace

std::string TextOf(const ConsoleAddress& address) {
  return fmt::format("{}:{}/{}{}", address.origin, address.port,
                     address.key.empty() ? "" : kKeyBegin, address.key);
}

Result<ConsoleAddress> ParseAddress(const std::string& text) {
  static const std::regex kForm(
      R"((http://127\.0\.0\.1|http://\[::1\]|https://[0-9a-zA-Z.:\[\]-]{1,253}))"
      R"(:([1-9][0-9]{0,4})/(\?key=([0-9a-f]{64}))?)");
  std::smatch parts;
  std::uint16_t port = 0;
  if (text.size() <= kMaxAddressBytes && std::regex_match(text, parts, kForm)) {
    const std::string digits = parts[2];
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), port);
    if (error == std::errc()) return ConsoleAddress{parts[1], port, parts[4]};
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("no address of a console: '{}'", text.substr(0, 100)));
}

Result<ConsoleAddress> ReadAddressFile(const std::filesystem::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxFileBytes));
  return ParseAddress(text.substr(0, text.find('\n')));
}

Status WriteAddressFile(const std::filesystem::path& file,
                        const ConsoleAddress& address) {
  return io::WriteFileAtomically(file, TextOf(address) + "\n", io::kSecretMode);
}

}  // namespace intaglio::console
