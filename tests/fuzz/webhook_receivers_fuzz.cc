// Any text as the receivers of webhooks: refused with a message, or each has a name, a
// URL and the file of a secret.

#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "services/console/webhooks/receivers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const auto receivers =
      console::ParseReceivers({reinterpret_cast<const char*>(bytes), size}, "fuzz");
  if (!receivers) {
    Require(!receivers.error().message.empty(), "an error without a sentence");
    return 0;
  }
  for (const WebhookReceiver& one : receivers->receivers()) {
    Require(!one.name().empty() && !one.url().empty() && !one.secret_file().empty(),
            "a field is missing");
  }
  return 0;
}
