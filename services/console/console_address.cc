#include "services/console/console_address.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/platform/access/secret_file.h"

namespace intaglio::console {
namespace {

constexpr std::string_view kBegin = "http://127.0.0.1:";
constexpr std::string_view kKeyBegin = "/?key=";
constexpr std::size_t kKeyDigits = 64;
constexpr std::uint64_t kMaxFileBytes = 4096;

bool IsHex(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); }

}  // namespace

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
  return access::WriteSecretFile(file, TextOf(address) + "\n");
}

}  // namespace intaglio::console
