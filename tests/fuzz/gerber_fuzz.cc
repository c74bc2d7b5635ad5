#include <cstdint>
#include <string_view>

#include "engrave/contour/files/gerber_read.h"
#include "engrave/core/check.h"

// A layer is refused with its file and line, or its elements are within the limits and
// can be rounded, or are refused by that with a sentence.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  intaglio::contour::GerberLimits limits;
  limits.max_elements = 5000;
  limits.max_edges = 20'000;
  const auto elements = intaglio::contour::ReadGerber(
      std::string_view(reinterpret_cast<const char*>(bytes), size), "a.gbr", limits);
  if (!elements) {
    Require(elements.error().message.starts_with("a.gbr: line "), "no line");
    return 0;
  }
  Require(elements->size() <= limits.max_elements, "too many elements");
  const auto rounded = intaglio::contour::Rounded(*elements);
  Require(rounded || !rounded.error().message.empty(), "an error without a sentence");
  return 0;
}
