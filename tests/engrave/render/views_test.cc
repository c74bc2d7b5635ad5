#include "engrave/render/views.h"

#include <gtest/gtest.h>

#include <random>

#include "engrave/core/check.h"
#include "engrave/render/png_file.h"
#include "engrave/render/views_layout.h"

namespace intaglio::render {
namespace {

const Vec3 kBlock(60, 60, 80);

ViewsCaption Caption() {
  ViewsCaption caption;
  caption.title_lines = {"bunny", "N-BK7, 60 × 60 × 80 mm"};
  caption.figures = {{"points", "20 000"}, {"error, rms", "0.4 µm", Tone::kGood}};
  caption.verdict = "PROVED";
  caption.verdict_tone = Tone::kGood;
  return caption;
}

/// Points on a sphere of radius 15 mm in the middle of the block.
PointList Sphere(int count) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> axis;
  PointList points;
  for (int i = 0; i < count; ++i) {
    const Vec3 way(axis(random), axis(random), axis(random));
    points.push_back(0.5 * kBlock + 15.0 * way.normalized());
  }
  return points;
}

double Brightness(const Canvas& canvas, const Rect& rect) {
  double sum = 0.0;
  for (int y = rect.y; y < rect.bottom(); ++y) {
    for (int x = rect.x; x < rect.right(); ++x) {
      const Color& color = canvas.at(x, y);
      sum += color.r + color.g + color.b;
    }
  }
  return sum / (rect.width * rect.height);
}

TEST(Views, HasItsSizeAndIsTheSameBitForBit) {
  const PointList cracks = Sphere(5000);
  const auto first = EncodePng(RenderViews(cracks, kBlock, Caption()));
  const auto second = EncodePng(RenderViews(cracks, kBlock, Caption()));
  EXPECT_EQ(first, second);
  const Canvas canvas = RenderViews(cracks, kBlock, Caption());
  EXPECT_EQ(canvas.width(), kViewsWidth);
  EXPECT_EQ(canvas.height(), kViewsHeight);
}

TEST(Views, EveryViewShowsTheCracks) {
  const Canvas empty = RenderViews({}, kBlock, Caption());
  const PointList cracks = Sphere(20000);
  const Canvas full = RenderViews(cracks, kBlock, Caption());
  const ViewsLayout layout = LayOutViews(cracks, kBlock, Caption());
  ASSERT_EQ(layout.panels.size(), 4u);
  for (const Panel& panel : layout.panels) {
    // The sphere is in the middle of the block, and the block in that of the panel.
    const Rect middle{panel.cell.x + panel.cell.width / 2 - 10,
                      panel.cell.y + panel.cell.height / 2 - 10, 20, 20};
    EXPECT_GT(Brightness(full, middle), 5 * Brightness(empty, middle)) << panel.name;
  }
  // The column at the right does not change with the cracks.
  const int right = layout.page.views.right();
  const Rect column{right, 0, kViewsWidth - right, kViewsHeight};
  EXPECT_EQ(Brightness(full, column), Brightness(empty, column));
}

TEST(Views, ASinglePointIsSeen) {
  const Canvas empty = RenderViews({}, kBlock, {});
  const Canvas one = RenderViews({0.5 * kBlock}, kBlock, {});
  const Rect all{0, 0, kViewsWidth, kViewsHeight};
  EXPECT_GT(Brightness(one, all), Brightness(empty, all));
}

TEST(Views, PointsOutsideTheBlockDoNoHarm) {
  const PointList cracks = {Vec3(-1000, 0, 0), Vec3(1e9, 1e9, 1e9), Vec3(30, 30, 500),
                            Vec3(0, 0, 0), kBlock};
  EXPECT_NO_THROW(RenderViews(cracks, kBlock, Caption()));
}

TEST(Views, OddBlocksAndLongCaptionsFit) {
  ViewsCaption caption = Caption();
  caption.title_lines.assign(6, std::string(400, 'W'));
  caption.figures.assign(60, {std::string(40, 'l'), std::string(200, '8')});
  for (const Vec3& block : {Vec3(300, 5, 5), Vec3(1, 1, 300), Vec3(0.5, 0.5, 0.5)}) {
    EXPECT_NO_THROW(RenderViews({0.5 * block}, block, caption));
  }
  EXPECT_THROW(RenderViews({}, Vec3(60, 0, 80), caption), PreconditionError);
}

TEST(Views, TheVerdictHasItsColour) {
  ViewsCaption caption = Caption();
  caption.verdict_tone = Tone::kBad;
  const Canvas bad = RenderViews({}, kBlock, caption);
  const Canvas good = RenderViews({}, kBlock, Caption());
  caption.verdict_tone = Tone::kWarning;
  const Canvas warned = RenderViews({}, kBlock, caption);
  const int x = kViewsWidth - 25;  // on the frame of the verdict
  EXPECT_GT(bad.at(x, 50).r, 2 * bad.at(x, 50).g);
  EXPECT_GT(good.at(x, 50).g, 2 * good.at(x, 50).r);
  EXPECT_GT(warned.at(x, 50).r, warned.at(x, 50).g);
  EXPECT_GT(warned.at(x, 50).g, 2 * warned.at(x, 50).b);
}

TEST(Views, ACameraGridStepAndFrameChangeThePicture) {
  const PointList cracks = Sphere(500);
  const auto picture = [&](const ViewsOptions& options) {
    return EncodePng(RenderViews(cracks, kBlock, Caption(), options));
  };
  ViewsOptions options;
  const auto usual = picture(options);
  options.object_frame = true;
  const auto framed = picture(options);
  EXPECT_NE(framed, usual);
  options.grid_step_mm = 7;
  const auto wide = picture(options);
  EXPECT_NE(wide, framed);
  options.grid_step_mm = 1e-9;  // a thousand million lines are not drawn
  EXPECT_NO_THROW(picture(options));
  options.camera = Camera{};
  const auto from_right = picture(options);
  options.camera->azimuth_rad = -0.52;
  const auto from_left = picture(options);
  EXPECT_NE(from_left, from_right);
  options.camera->parallel = true;
  EXPECT_NE(picture(options), from_left);
  const auto straight = picture(options);
  options.camera->roll_rad = 1;
  EXPECT_NE(picture(options), straight);
  options.camera->roll_rad = 4;
  EXPECT_THROW(picture(options), PreconditionError);
  options.camera->roll_rad = 0;
  options.camera->elevation_rad = 2;
  EXPECT_THROW(picture(options), PreconditionError);
  options.camera = Camera{.zoom = 0.5};
  EXPECT_THROW(picture(options), PreconditionError);
}

}  // namespace
}  // namespace intaglio::render
