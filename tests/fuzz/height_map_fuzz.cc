#include <cmath>
#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/post/height_map.h"

// A file of heights is refused with its name, or it has a finite height everywhere.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto map = post::ParseHeightMap(text, "a.txt", {1, 2, 3});
  if (!map) {
    Require(map.error().message.starts_with("a.txt"), "an error without the file");
    return 0;
  }
  for (const double at : {-1e6, -1.0, 0.0, 0.3, 1e6}) {
    const double height = map->At({at, -at});
    Require(height >= map->min_mm() && height <= map->max_mm(), "beyond its heights");
  }
  post::ToolPath path{"a", {0, 0}, {post::LineTo({1, 2}), post::LineTo({-3, 1})}};
  Require(map->Divided(path, Vec2::Zero(), 0.001).moves.size() >= 2, "a way is lost");
  return 0;
}
