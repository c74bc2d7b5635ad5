#include "engrave/drawing/dxf/dxf_read.h"
#include "tests/fuzz/drawing_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::drawing::FuzzReader;
  FuzzReader(intaglio::drawing::ReadDxf, bytes, size);
  const intaglio::drawing::FontSource font{"DejaVu Sans"};
  return FuzzReader(intaglio::drawing::ReadDxf, bytes, size, font);
}
