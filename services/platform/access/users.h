#pragma once

// The people who may log in to a console, in a file that its owner alone can read: a line
// "NAME:ROLE:HASH" of each, the hash as libsodium writes it (crypto_pwhash_str,
// argon2id), so that the file has no password.
//
// Cost of a hash: 2 passes over 19 MiB, the smallest that OWASP's Password Storage Cheat
// Sheet (2025, "Argon2id") recommends; some 30 ms, and little memory for the host of a
// machine.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::access {

enum class UserRole {
  kObserver,  ///< looks, and presses Stop
  kOperator,  ///< also commands
};
/// "observer", "operator".
const char* NameOf(UserRole role);
/// kInvalidValue: another name.
Result<UserRole> UserRoleNamed(std::string_view name);

struct User {
  std::string name;
  UserRole role = UserRole::kObserver;
  std::string hash;
};

inline constexpr std::size_t kMaxNameBytes = 64;
inline constexpr std::size_t kMinPasswordBytes = 10;
inline constexpr std::size_t kMaxPasswordBytes = 256;

/// kInvalidValue: empty or too long, or with a space, a colon or a control character.
Status CheckUserName(std::string_view name);
/// kInvalidValue: too short or too long.
Status CheckPassword(std::string_view password);

/// Takes some 30 ms. Throws when there is no memory for it.
std::string HashOf(const std::string& password);
/// As long. False as well when the hash is of another kind.
bool Matches(const std::string& hash, const std::string& password);

/// kInvalidValue names the line: of another form, a name twice.
Result<std::vector<User>> ParseUsers(const std::string& text);
/// What ParseUsers reads.
std::string TextOf(const std::vector<User>& users);

/// kNotFound: there is no such file. kRefused: others can read or write it.
/// kInvalidValue.
Result<std::vector<User>> ReadUsers(const std::filesystem::path& file);
/// kIo.
Status WriteUsers(const std::filesystem::path& file, const std::vector<User>& users);

}  // namespace intaglio::access
