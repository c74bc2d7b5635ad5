#include "services/platform/access/new_key.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cerrno>

#include "engrave/core/check.h"

namespace intaglio::access {

std::string NewKey() {
  std::array<unsigned char, 32> bytes{};
  Require(getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
          "getrandom failed with errno {}", errno);
  std::string key;
  for (const unsigned char byte : bytes) key += fmt::format("{:02x}", byte);
  return key;
}

}  // namespace intaglio::access
