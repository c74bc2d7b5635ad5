#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/isolation.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/core/check.h"

// Copper on exact grids, as boards have it: isolated, each piece of copper has its own
// contour, or refused with a sentence; and the pairs of boxes are those of a walk over
// all.
namespace {

using intaglio::Require;
using intaglio::Vec2;
using namespace intaglio::contour;

/// Whole hundredths of mm, or mils.
class Numbers {
 public:
  Numbers(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes, size) {
    step_mm_ = Byte() % 2 == 0 ? 0.01 : 0.0254;
  }
  bool empty() const { return bytes_.empty(); }
  int Byte() {
    if (bytes_.empty()) return 0;
    const int byte = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return byte;
  }
  double Length() { return (Byte() + 1) * step_mm_; }
  Vec2 Place() {
    const int x = Byte(), y = Byte();
    return Vec2(x, y) * step_mm_;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  double step_mm_ = 0.01;
};

void CheckPairs(const std::vector<FlatBox>& boxes, double margin_mm) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size(); ++j) {
      const Vec2 min = boxes[i].min_mm.cwiseMax(boxes[j].min_mm);
      const Vec2 max = boxes[i].max_mm.cwiseMin(boxes[j].max_mm);
      if (min.x() <= max.x() + margin_mm && min.y() <= max.y() + margin_mm) ++count;
    }
  }
  Require(NearPairs(boxes, margin_mm).size() == count, "a pair too many or too few");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  Numbers numbers(bytes, std::min<std::size_t>(size, 200));
  const double tool_mm = numbers.Length();
  std::vector<Element> elements;
  std::vector<FlatBox> boxes;
  while (!numbers.empty()) {
    const int kind = numbers.Byte() % 3;
    const Vec2 at = numbers.Place();
    const double side_mm = numbers.Length();
    const Vec2 half = Vec2::Constant(side_mm / 2);
    boxes.push_back({at - half, at + half});
    if (kind == 0)
      elements.push_back({Circle{at, side_mm}});
    else if (kind == 1)
      elements.push_back({Square{at, side_mm}});
    else
      elements.push_back({Track{at, numbers.Place(), side_mm}});
  }
  CheckPairs(boxes, tool_mm);
  const auto isolation = Isolate(elements, {tool_mm});
  if (!isolation) {
    Require(!isolation.error().message.empty(), "an error without a sentence");
    return 0;
  }
  Require(isolation->piece_count == isolation->net_count, "nets in one piece");
  return 0;
}
