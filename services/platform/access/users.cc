#include "services/platform/access/users.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "services/platform/access/secret_file.h"

namespace intaglio::access {
namespace {

namespace fs = std::filesystem;

constexpr unsigned long long kPasses = 2;
constexpr std::size_t kMemoryBytes = 19 << 20;
constexpr std::uint64_t kMaxFileBytes = 1 << 20;

void StartSodium() { Require(sodium_init() >= 0, "libsodium does not start"); }

tl::unexpected<Error> WrongLine(int line, const std::string& why) {
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("users, line {}: {}; a line is NAME:ROLE:HASH, as `intaglio "
                          "console user add` writes it",
                          line, why));
}

Result<User> ParseUser(const std::string& line, int number) {
  const auto name_end = line.find(':');
  const auto role_end =
      name_end == std::string::npos ? name_end : line.find(':', name_end + 1);
  if (role_end == std::string::npos) return WrongLine(number, "it has no two colons");
  User user;
  user.name = line.substr(0, name_end);
  if (const auto named = CheckUserName(user.name); !named)
    return WrongLine(number, named.error().message);
  const auto role = UserRoleNamed(line.substr(name_end + 1, role_end - name_end - 1));
  if (!role) return WrongLine(number, role.error().message);
  user.role = *role;
  user.hash = line.substr(role_end + 1);
  const bool printable = std::all_of(user.hash.begin(), user.hash.end(),
                                     [](char c) { return c > ' ' && c < 0x7f; });
  if (!user.hash.starts_with("$argon2id$") || !printable ||
      user.hash.size() >= crypto_pwhash_STRBYTES)
    return WrongLine(number, "its hash is not of argon2id");
  return user;
}

}  // namespace

const char* NameOf(UserRole role) {
  return role == UserRole::kOperator ? "operator" : "observer";
}

Result<UserRole> UserRoleNamed(std::string_view name) {
  for (const UserRole role : {UserRole::kObserver, UserRole::kOperator}) {
    if (name == NameOf(role)) return role;
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("role '{}': use observer or operator", name.substr(0, 40)),
              std::string(name));
}

Status CheckUserName(std::string_view name) {
  const bool is_plain = std::none_of(name.begin(), name.end(), [](char c) {
    return c == ':' || c == 0x7f || static_cast<unsigned char>(c) <= ' ';
  });
  if (is_plain && !name.empty() && name.size() <= kMaxNameBytes) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("a name of a user has 1 to {} bytes, and no space and no colon",
                          kMaxNameBytes),
              std::string(name));
}

Status CheckPassword(std::string_view password) {
  if (password.size() >= kMinPasswordBytes && password.size() <= kMaxPasswordBytes)
    return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("a password has {} to {} bytes", kMinPasswordBytes, kMaxPasswordBytes));
}

std::string HashOf(const std::string& password) {
  StartSodium();
  std::array<char, crypto_pwhash_STRBYTES> hash{};
  Require(crypto_pwhash_str(hash.data(), password.data(), password.size(), kPasses,
                            kMemoryBytes) == 0,
          "no memory for the hash of a password");
  return hash.data();
}

bool Matches(const std::string& hash, const std::string& password) {
  StartSodium();
  return hash.size() < crypto_pwhash_STRBYTES &&
         crypto_pwhash_str_verify(hash.c_str(), password.data(), password.size()) == 0;
}

Result<std::vector<User>> ParseUsers(const std::string& text) {
  std::vector<User> users;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.empty() || line.starts_with('#')) continue;
    auto user = INTAGLIO_TRY(ParseUser(line, number));
    const bool is_there = std::any_of(users.begin(), users.end(), [&](const User& one) {
      return one.name == user.name;
    });
    if (is_there) return WrongLine(number, "its name is there before");
    users.push_back(std::move(user));
  }
  return users;
}

std::string TextOf(const std::vector<User>& users) {
  std::string text;
  for (const User& user : users)
    text += fmt::format("{}:{}:{}\n", user.name, NameOf(user.role), user.hash);
  return text;
}

Result<std::vector<User>> ReadUsers(const fs::path& file) {
  const auto text = INTAGLIO_TRY(ReadSecretFile(file, kMaxFileBytes));
  return ParseUsers(text);
}

Status WriteUsers(const fs::path& file, const std::vector<User>& users) {
  return io::WriteFileAtomically(file, TextOf(users), io::kSecretMode);
}

}  // namespace intaglio::access
