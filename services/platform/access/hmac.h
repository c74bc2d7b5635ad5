#pragma once

// HMAC-SHA256 (RFC 2104 and FIPS 180-4): a receiver that has the secret can check who has
// sent a message, and that nobody changed it.

#include <string>
#include <string_view>

namespace intaglio::access {

/// 64 hex digits, lower case. A secret and a message of any length.
std::string HmacSha256(std::string_view secret, std::string_view message);

}  // namespace intaglio::access
