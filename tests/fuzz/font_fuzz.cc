// Any bytes as a font's file: refused with a message, or text in it has finite curves.

#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/drawing/font_outline.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  drawing::TextOptions options;
  options.font = {"a.ttf", std::string_view(reinterpret_cast<const char*>(bytes), size)};
  if (size == 0) return 0;  // then the file is read
  const auto outline = drawing::TextOutline("AV\nHH", options);
  if (!outline) Require(!outline.error().message.empty(), "an error without a sentence");
  return 0;
}
