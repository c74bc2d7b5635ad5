#include "services/console/webhooks/signed_request.h"

#include <fmt/format.h>

#include "services/platform/access/hmac.h"

namespace intaglio::console {

std::vector<std::string> HeadersOf(const Delivery& delivery, std::string_view secret,
                                   std::uint64_t dropped,
                                   std::chrono::system_clock::time_point now) {
  const auto time_s =
      std::chrono::duration_cast<std::chrono::seconds>(now.time_since_epoch()).count();
  const std::string code =
      access::HmacSha256(secret, fmt::format("{}.{}", time_s, *delivery.body));
  return {"Content-Type: application/json",
          fmt::format("Intaglio-Event: {}", delivery.event),
          fmt::format("Intaglio-Delivery: {}", delivery.id),
          fmt::format("Intaglio-Dropped: {}", dropped),
          fmt::format("Intaglio-Timestamp: {}", time_s),
          fmt::format("Intaglio-Signature: v1={}", code)};
}

}  // namespace intaglio::console
