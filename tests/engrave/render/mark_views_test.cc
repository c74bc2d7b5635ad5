#include "engrave/render/web/mark_views.h"

#include <gtest/gtest.h>

namespace intaglio::render {
namespace {

/// A row of short strokes along x, 10 mm apart.
MarkViews Strokes(int count) {
  MarkViews views;
  views.tolerance_um = 20;
  for (int i = 0; i < count; ++i) {
    ShownMark mark;
    mark.way_mm = {Vec2(10.0 * i, 0), Vec2(10.0 * i + 5, 5)};
    mark.middle_mm = {10.0 * i + 2.5, 2.5};
    views.marks.push_back(mark);
  }
  return views;
}

/// Pixels near to this colour.
int CountOf(const Canvas& canvas, const Color& color, const Rect& within) {
  int count = 0;
  for (int y = within.y; y < within.bottom(); ++y)
    for (int x = within.x; x < within.right(); ++x) {
      const Color& c = canvas.at(x, y);
      count +=
          std::abs(c.r - color.r) + std::abs(c.g - color.g) + std::abs(c.b - color.b) <
                  0.06F
              ? 1
              : 0;
    }
  return count;
}

const Rect kAll{0, 0, kViewsWidth, kViewsHeight};
const Color kMissedColor = Srgb(0xFF4D4D), kDoubledColor = Srgb(0xE76BF3);

TEST(MarkViews, AMissedMarkIsRedAndRinged) {
  MarkViews views = Strokes(4);
  EXPECT_EQ(CountOf(DrawMarkViews(views), kMissedColor, kAll), 0);
  views.marks[2].state = MarkState::kMissed;
  const int one = CountOf(DrawMarkViews(views), kMissedColor, kAll);
  EXPECT_GT(one, 100);
  views.marks[1].state = MarkState::kMissed;
  EXPECT_GT(CountOf(DrawMarkViews(views), kMissedColor, kAll), 1.5 * one);
  EXPECT_EQ(CountOf(DrawMarkViews(views), kDoubledColor, kAll), 0);
}

TEST(MarkViews, ArrowsAreLongerThanOffsetsByARoundNumber) {
  MarkViews views = Strokes(4);
  EXPECT_EQ(OffsetMagnification(views.marks, 10), 1);
  views.marks[0].offset_mm = Vec2(1e-15, 0);
  EXPECT_EQ(OffsetMagnification(views.marks, 10), 50000);
  views.marks[0].offset_mm = Vec2(0.003, 0.004);
  // 60 pixels are 6 mm: 1200 times 5 um.
  EXPECT_EQ(OffsetMagnification(views.marks, 10), 1000);
  views.marks[1].offset_mm = Vec2(0, 50);
  EXPECT_EQ(OffsetMagnification(views.marks, 10), 1);
}

CloseUp Stroke(double off_mm) {
  CloseUp close_up;
  close_up.mark.way_mm = {Vec2(0, 0), Vec2(12, 0)};
  for (int i = 0; i < 12; ++i)
    close_up.burnt.push_back({Vec2(i, off_mm), Vec2(i + 1.0, off_mm)});
  return close_up;
}

TEST(MarkViews, ACloseUpMagnifiesSoThatItFits) {
  // The tolerance of 20 um is a twelfth of 12 mm at 50 times.
  EXPECT_EQ(CloseUpMagnification(Stroke(0.005), 20), 50);
  // 0.5 mm are a quarter of it at 6 times.
  EXPECT_EQ(CloseUpMagnification(Stroke(0.5), 20), 5);
  EXPECT_EQ(CloseUpMagnification(Stroke(0), 0), 1);
  CloseUp nothing = Stroke(0);
  nothing.burnt.clear();
  EXPECT_EQ(CloseUpMagnification(nothing, 20), 50);
}

TEST(MarkViews, ErrorsBeyondTheToleranceAreRed) {
  MarkViews views = Strokes(4);
  views.errors = {{5}, {10}, {15}, {18}};
  const Color bad = Srgb(0xFF6B5E);
  EXPECT_EQ(CountOf(DrawMarkViews(views), bad, kAll), 0);
  views.errors[2].error_um = 30;
  EXPECT_GT(CountOf(DrawMarkViews(views), bad, kAll), 200);
}

// Nothing, one place, a thousand fields in a row, marks of no extent.
TEST(MarkViews, DrawsWhatHasNoExtent) {
  EXPECT_EQ(DrawMarkViews({}).width(), kViewsWidth);
  MarkViews one;
  one.marks = {{{Vec2(3, 4)}, Vec2(3, 4), MarkState::kMissed, std::nullopt}};
  one.errors = {{0, MarkState::kMissed}};
  one.close_ups = {{"mark 1", {"a hole"}, one.marks[0], {}}};
  EXPECT_GT(CountOf(DrawMarkViews(one), kMissedColor, kAll), 10);
  MarkViews long_web = Strokes(3000);
  long_web.errors.assign(3000, {1, MarkState::kMade});
  EXPECT_EQ(DrawMarkViews(long_web).height(), kViewsHeight);
}

}  // namespace
}  // namespace intaglio::render
