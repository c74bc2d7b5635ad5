// Any bytes as a schema's IDL text, and behind its first zero byte as a message of every
// type in it: a value that can be printed, or an error with a sentence.

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "services/platform/recording/cdr_value.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::recording;
  const auto* end = std::find(bytes, bytes + size, 0);
  const std::string idl(bytes, end);
  const auto types = ParseIdl(idl);
  if (!types) {
    if (types.error().message.empty()) std::abort();
    return 0;
  }
  const auto payload = std::as_bytes(std::span(end, bytes + size));
  for (const auto& [name, type] : types->structs) {
    const auto value = DecodeCdr(*types, name, payload);
    if (value ? JsonOf(*value).empty() : value.error().message.empty()) std::abort();
  }
  return 0;
}
