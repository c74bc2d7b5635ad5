#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/galvo/files/ct5_tables.h"

// The input is laid over a whole file from a place that its first four bytes give, for a
// file of a megabyte would hardly ever have the right size. A file is refused with its
// name, or written again it is the same, and its grid is one.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  using namespace intaglio::galvo;
  static const std::string whole = [] {
    Ct5 file;
    file.header[kCt5Calibration] = 1000;
    for (auto& table : file.tables) table.assign(257 * 257, kCt5Zero);
    return WriteCt5(file);
  }();
  std::string text = whole;
  if (size >= 4) {
    std::uint32_t at = 0;
    std::memcpy(&at, bytes, 4);
    at %= text.size();
    const std::size_t count = std::min(size - 4, text.size() - at);
    std::memcpy(text.data() + at, bytes + 4, count);
    if (at % 7 == 6) text.resize(at);
  }
  const auto file = ReadCt5(text, "a.ct5");
  if (!file) {
    Require(file.error().message.starts_with("a.ct5: "), "an error without the file");
    return 0;
  }
  // A megabyte each: what reads is tried more often.
  if (size % 4 == 0) Require(WriteCt5(*file) == text, "written again it is another file");
  if (size % 16 == 0) Require(CheckGrid(GridOf(*file)).has_value(), "its grid is none");
  return 0;
}
