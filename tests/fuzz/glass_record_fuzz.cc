// Any bytes as the record of a glass: its cracks, or an error with a message.

#include <cstdint>
#include <cstdlib>
#include <span>

#include "engrave/formats/glass_record.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::formats;
  const auto record = ParseGlassRecord(std::as_bytes(std::span(bytes, size)));
  if (!record && record.error().message.empty()) std::abort();
  return 0;
}
