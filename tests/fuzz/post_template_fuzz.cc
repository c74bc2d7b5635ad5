#include <cstdint>
#include <string_view>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/post/point_program.h"

namespace {
// As point_program.h has them: of begin, point and end.
constexpr int kVariableCounts[] = {4, 12, 4};
}  // namespace

// A template is refused with its file and line, or every fragment can be written.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  const auto program = intaglio::post::ParsePointTemplate(
      std::string_view(reinterpret_cast<const char*>(bytes), size), "a.post");
  if (!program) {
    Require(program.error().message.starts_with("a.post: "), "an error without the file");
    return 0;
  }
  Require(program->fragments.size() == 3, "fragments are missing");
  for (std::size_t k = 0; k < 3; ++k) {
    for (const auto& piece : program->fragments[k].pieces) {
      Require(piece.variable >= -1 && piece.variable < kVariableCounts[k],
              "a variable of no rule");
    }
  }
  for (const auto& [name, format] : program->numbers) {
    std::string text;
    intaglio::post::AppendNumber(-1234.5678, format, text);
    Require(!text.empty() && text.size() < 40, "a number of a wrong length");
  }
  return 0;
}
