#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/galvo/files/correction_files.h"

// The input is laid over the beginning of a file of each layout's size, for inputs of the
// right size would be rare. A file is refused with its name, or its grid is one.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  using namespace intaglio::galvo;
  const auto check = [](const auto& grid) {
    if (grid) {
      Require(CheckGrid(*grid).has_value(), "a grid that is none");
    } else {
      Require(grid.error().message.starts_with("a.cor: "), "an error without the file");
    }
  };
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  check(ReadCor(text, "a.cor"));
  check(ReadCtb(text, "a.cor", 500));
  for (const std::size_t whole : {33'840, 68'128, 16'900}) {
    std::string laid(whole, '\0');
    std::memcpy(laid.data(), bytes, std::min(size, whole));
    check(ReadCor(laid, "a.cor"));
    check(ReadCtb(laid, "a.cor", 500));
  }
  return 0;
}
