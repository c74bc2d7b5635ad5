#include "services/platform/access/hmac.h"

#include <fmt/format.h>
#include <sodium.h>

#include <array>

#include "engrave/core/check.h"

namespace intaglio::access {
namespace {

const unsigned char* BytesOf(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

}  // namespace

std::string HmacSha256(std::string_view secret, std::string_view message) {
  Require(sodium_init() >= 0, "libsodium does not start");
  crypto_auth_hmacsha256_state state;
  crypto_auth_hmacsha256_init(&state, BytesOf(secret), secret.size());
  crypto_auth_hmacsha256_update(&state, BytesOf(message), message.size());
  std::array<unsigned char, crypto_auth_hmacsha256_BYTES> code{};
  crypto_auth_hmacsha256_final(&state, code.data());
  std::string text;
  for (const unsigned char byte : code) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace intaglio::access
