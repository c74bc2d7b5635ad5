#include "engrave/drawing/nci/nci_read.h"
#include "tests/fuzz/drawing_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return intaglio::drawing::FuzzReader(intaglio::drawing::ReadNci, bytes, size);
}
