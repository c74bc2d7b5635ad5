#include "engrave/drawing/dxf/dxf_read.h"
#include "tests/fuzz/drawing_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return intaglio::drawing::FuzzReader(intaglio::drawing::ReadDxf, bytes, size);
}
