#include <cstdint>
#include <string_view>
#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/core/check.h"
#include "engrave/post/drill_program.h"
#include "engrave/post/mill_program.h"

namespace {

using namespace intaglio;

/// A template is refused with its file, or it makes programs within their maximum size.
void TryMill(std::string_view text) {
  const auto program = post::ParseMillTemplate(text, "a.post");
  if (!program) {
    Require(program.error().message.starts_with("a.post: "), "an error without the file");
    return;
  }
  const std::vector<post::ToolPath> paths(
      2,
      post::PathOf({contour::MakeLine({0, 0}, {1, 2}), contour::MakeArc({0, 2}, 1, 0, -4),
                    contour::MakeArc({0, 2}, 1, 1, 2)},
                   "contour"));
  post::Cutting cutting;
  cutting.power_ratio = 0.5;
  post::MillOptions options;
  options.max_bytes = 10'000;
  const auto texts = post::MillPrograms(*program, paths, cutting, options);
  if (!texts) return;
  for (const std::string& part : *texts) {
    Require(texts->size() == 1 || part.size() <= 10'000, "a part that is too long");
  }
}

void TryDrill(std::string_view text) {
  const auto program = post::ParseDrillTemplate(text, "a.post");
  if (!program) {
    Require(program.error().message.starts_with("a.post: "), "an error without the file");
    return;
  }
  post::Cutting cutting;
  cutting.power_ratio = 0.5;
  const std::vector<post::DrillRound> rounds = {{0.8, {{1, 2}, {3, 4}}}, {1.2, {{5, 6}}}};
  const auto texts = post::DrillPrograms(*program, rounds, cutting);
  Require(!texts || !texts->empty(), "no program");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  TryMill(text);
  TryDrill(text);
  return 0;
}
