#pragma once

// Boards for the tests and measurements: pads and tracks on a raster of 2.54 mm, with
// elements twice, tracks on each other and tracks that end between pads.

#include <random>
#include <vector>

#include "engrave/contour/element.h"

namespace intaglio::contour::test {

/// A number of 0 .. 1, the same with every library.
inline double Random(std::mt19937& random) {
  return static_cast<double>(random()) / 4294967296.0;
}

struct BoardOptions {
  int count = 30;
  unsigned seed = 1;
  bool free_angles = false;  ///< else tracks run along the raster and at 45 degrees
  double moved_mm = 0;       ///< each place of each element is moved by up to this
};

class BoardMaker {
 public:
  explicit BoardMaker(const BoardOptions& options)
      : options_(options),
        random_(options.seed),
        side_(std::max(2, static_cast<int>(std::sqrt(0.6 * options.count)))) {}

  std::vector<Element> Make() {
    std::vector<Element> board;
    while (static_cast<int>(board.size()) < options_.count) {
      const int x = Number(side_);
      const int y = Number(side_);
      if (Random(random_) < 0.5)
        board.push_back({Pad(x, y), {}});
      else if (const Vec2 begin = At(x, y), end = FarEnd(x, y); begin != end)
        board.push_back({Track{Moved(begin), Moved(end), Width()}, {}});
    }
    return board;
  }

 private:
  int Number(int count) { return static_cast<int>(Random(random_) * count); }
  double Width() { return Random(random_) < 0.7 ? 0.4 : 0.8; }
  Vec2 At(int x, int y) const {
    Vec2 place = 2.54 * Vec2(x, y);
    if (options_.free_angles && (7 * x + 13 * y) % 5 == 0) place += Vec2(0.3, -0.2);
    return place;
  }
  Vec2 Moved(const Vec2& place) {
    const double x = 2 * Random(random_) - 1;
    const double y = 2 * Random(random_) - 1;
    return place + options_.moved_mm * Vec2(x, y);
  }
  Shape Pad(int x, int y) {
    const double size = Random(random_) < 0.5 ? 1.8 : 1.4;
    const Vec2 place = Moved(At(x, y));
    switch (Number(3)) {
      case 0:
        return Circle{place, size};
      case 1:
        return Square{place, size};
      default:
        return Octagon{place, size};
    }
  }
  Vec2 FarEnd(int x, int y) {
    const int dx = Number(3) - 1;
    int dy = Number(3) - 1;
    const int length = 1 + Number(3);
    if (options_.free_angles && Random(random_) < 0.4) ++dy;
    return At(std::clamp(x + dx * length, 0, side_),
              std::clamp(y + dy * length, 0, side_));
  }

  BoardOptions options_;
  std::mt19937 random_;
  int side_;
};

inline std::vector<Element> MakeBoard(const BoardOptions& options) {
  return BoardMaker(options).Make();
}

}  // namespace intaglio::contour::test
