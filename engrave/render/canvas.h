#pragma once

// A picture to draw on: linear-light RGB in floats, so that glow adds up as light does;
// it becomes sRGB only when it is written (png_file.h). Units are pixels, x to the
// right, y down; pixel (i, j) covers i..i+1, j..j+1. Everything is anti-aliased, and
// what lies outside the canvas is not drawn.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::render {

/// Linear light, 0..1 as shown; more is allowed and saturates.
struct Color {
  float r = 0.0F;
  float g = 0.0F;
  float b = 0.0F;

  friend Color operator*(float k, const Color& c) { return {k * c.r, k * c.g, k * c.b}; }
  friend Color operator+(const Color& p, const Color& q) {
    return {p.r + q.r, p.g + q.g, p.b + q.b};
  }
};

/// The colour written 0xRRGGBB in sRGB.
Color Srgb(std::uint32_t rgb);

/// a at t = 0, b at t = 1.
inline Color Mix(const Color& a, const Color& b, float t) {
  return (1.0F - t) * a + t * b;
}

/// Pixels between a rectangle and what is drawn inside it.
struct Margins {
  int left = 0, right = 0, top = 0, bottom = 0;
};

/// A rectangle of pixels.
struct Rect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  int right() const { return x + width; }
  Rect Inside(const Margins& margins) const {
    return {x + margins.left, y + margins.top, width - margins.left - margins.right,
            height - margins.top - margins.bottom};
  }
  int bottom() const { return y + height; }
  Rect Inset(int by) const { return {x + by, y + by, width - 2 * by, height - 2 * by}; }
};

class Canvas {
 public:
  /// Black. Both sides 1 .. 16384.
  Canvas(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  bool Has(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  /// The pixel must be on the canvas.
  Color& at(int x, int y) { return pixels_[Index(x, y)]; }
  const Color& at(int x, int y) const { return pixels_[Index(x, y)]; }

  /// Covers the share `alpha` (0..1) of a pixel; does nothing outside the canvas.
  void Blend(int x, int y, const Color& color, float alpha) {
    if (Has(x, y)) at(x, y) = Mix(at(x, y), color, alpha);
  }

 private:
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  int width_;
  int height_;
  std::vector<Color> pixels_;
};

/// Colour, and the share of it that covers.
struct Paint {
  Color color;
  float alpha = 1.0F;
};

/// A line with round ends. Widths below one pixel are drawn fainter, not thinner.
void DrawLine(Canvas& canvas, const Vec2& from_px, const Vec2& to_px, double width_px,
              const Paint& paint);
void DrawDisc(Canvas& canvas, const Vec2& center_px, double radius_px,
              const Paint& paint);
/// A convex polygon of either sense of rotation, at least 3 corners.
void FillConvex(Canvas& canvas, const std::vector<Vec2>& corners_px, const Paint& paint);
/// What the closed loops wind around: an outer loop and the holes in it run in opposite
/// senses, and loops of the same sense that overlap are one area. A pixel is covered by
/// the share of it that lies inside, summed over four rows.
void FillLoops(Canvas& canvas, const std::vector<std::vector<Vec2>>& loops_px,
               const Paint& paint);
void FillRect(Canvas& canvas, const Rect& rect, const Paint& paint);
/// The outline of a rectangle, one pixel wide, inside it.
void FrameRect(Canvas& canvas, const Rect& rect, const Paint& paint);

}  // namespace intaglio::render
