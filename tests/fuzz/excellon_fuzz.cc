#include <cmath>
#include <cstdint>
#include <string_view>

#include "engrave/contour/files/excellon_read.h"
#include "engrave/core/check.h"

// A drill file is refused with its name and line, or all its holes have a finite place
// and a size.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  intaglio::contour::ExcellonOptions options;
  options.max_holes = 10'000;
  if (size > 0 && bytes[0] % 2 == 1) options.units = "INCH,TZ";
  const auto file = intaglio::contour::ReadExcellon(
      std::string_view(reinterpret_cast<const char*>(bytes), size), "a.drl", options);
  if (!file) {
    Require(file.error().message.starts_with("a.drl: line "),
            "an error without its line");
    return 0;
  }
  Require(file->holes.size() + file->slots.size() <= options.max_holes, "too many holes");
  for (const auto& hole : file->holes) {
    Require(hole.center_mm.allFinite() && hole.diameter_mm > 0, "a hole of no size");
  }
  return 0;
}
