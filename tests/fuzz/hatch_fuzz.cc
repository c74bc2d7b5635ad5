// Hatching of any contours: lines stay within their extent, and nothing else happens.

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "engrave/mark/hatch.h"

namespace {

/// The next number of the input; of what is left of it, 0.
class Numbers {
 public:
  Numbers(const std::uint8_t* bytes, std::size_t count) : bytes_(bytes), count_(count) {}
  bool empty() const { return count_ < 2; }
  double Next() {
    std::int16_t number = 0;
    if (!empty()) {
      std::memcpy(&number, bytes_, 2);
      bytes_ += 2, count_ -= 2;
    }
    return number / 64.0;
  }

 private:
  const std::uint8_t* bytes_;
  std::size_t count_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace intaglio;
  Numbers numbers(data, std::min<std::size_t>(size, 4000));
  mark::HatchOptions options;
  options.distance_mm = std::abs(numbers.Next()) + 0.5;
  options.angle_rad = numbers.Next();
  options.cross = numbers.Next() > 0;
  options.rule =
      numbers.Next() > 0 ? mark::InsideRule::kNonZero : mark::InsideRule::kEvenOdd;
  std::vector<std::vector<Vec2>> contours(1);
  Box3 box;
  while (!numbers.empty()) {
    const Vec2 place(numbers.Next(), numbers.Next());
    if (place.x() > 500) contours.emplace_back();
    contours.back().push_back(place);
    box.Extend(Vec3(place.x(), place.y(), 0));
  }
  const auto chords = mark::Hatch(contours, options);
  if (!chords) return 0;
  for (const mark::Chord& chord : *chords) {
    for (const Vec2& p : {chord.from_mm, chord.to_mm}) {
      const Vec3 margin(1e-6, 1e-6, 0), at(p.x(), p.y(), 0);
      if (((at - box.max_mm).array() > margin.array()).any()) std::abort();
      if (((box.min_mm - at).array() > margin.array()).any()) std::abort();
    }
  }
  return 0;
}
