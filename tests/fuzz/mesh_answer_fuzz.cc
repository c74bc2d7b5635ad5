// Any bytes as the answer of the process that reads meshes: nothing, or an answer that
// is written as it was read.

#include <algorithm>
#include <cstdint>
#include <span>

#include "engrave/core/check.h"
#include "services/job/models/mesh_answer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const auto input = std::as_bytes(std::span(bytes, size));
  const auto answer = mesh_reader::ParseAnswer(input);
  if (!answer) return 0;
  const auto again = mesh_reader::EncodeAnswer(*answer);
  Require(std::equal(again.begin(), again.end(), input.begin(), input.end()),
          "an answer is read as another one");
  return 0;
}
