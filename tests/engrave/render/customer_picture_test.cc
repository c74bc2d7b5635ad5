#include "engrave/render/customer_picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "engrave/core/check.h"
#include "tests/test_folder.h"

namespace intaglio::render {
namespace {

const Vec3 kPieceBlock(60, 40, 50);

/// Points on a sphere in the middle of the block.
PointList Ball(double radius_mm) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> axis;
  PointList points;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 way(axis(random), axis(random), axis(random));
    points.push_back(0.5 * kPieceBlock + radius_mm * way.normalized());
  }
  return points;
}

/// A disc in the plane y = 20, in the upper right quarter of the block's front.
PointList Disc() {
  PointList points;
  for (double x = -9; x <= 9; x += 0.3) {
    for (double z = -9; z <= 9; z += 0.3) {
      if (std::hypot(x, z) <= 9) points.emplace_back(45 + x, 20, 37 + z);
    }
  }
  return points;
}

double Light(const Canvas& canvas, double x_ratio, double y_ratio) {
  const int cx = static_cast<int>(x_ratio * canvas.width());
  const int cy = static_cast<int>(y_ratio * canvas.height());
  double sum = 0;
  for (int y = cy - 10; y <= cy + 10; ++y) {
    for (int x = cx - 10; x <= cx + 10; ++x) {
      const Color& color = canvas.at(x, y);
      sum += color.r + color.g + color.b;
    }
  }
  return sum / 441;
}

TEST(CustomerPicture, ItsLongerSideIsAsAskedFor) {
  for (const int side : {400, 1100}) {
    for (const Vec3& block : {Vec3(60, 40, 50), Vec3(20, 20, 90), Vec3(120, 5, 20)}) {
      for (const char* name : {"", "Ada"}) {
        const Canvas canvas = RenderCustomerPicture(
            {0.5 * block, 0.4 * block}, block, {.longer_side_px = side, .name = name});
        EXPECT_NEAR(std::max(canvas.width(), canvas.height()), side, 3);
        EXPECT_GE(std::min(canvas.width(), canvas.height()), side * 0.4);
      }
    }
  }
}

TEST(CustomerPicture, FlatWorkIsWhereItIsRead) {
  const Canvas canvas =
      RenderCustomerPicture(Disc(), kPieceBlock, {.longer_side_px = 500});
  // x 45 of 60, and 50 - 37 of 50 from above, with margins of a twentieth.
  const double at = Light(canvas, 0.05 + 0.9 * 45 / 60, 0.06 + 0.88 * 13 / 50);
  EXPECT_GT(at, 10 * Light(canvas, 0.05 + 0.9 * 15 / 60, 0.06 + 0.88 * 13 / 50));
  EXPECT_GT(at, 10 * Light(canvas, 0.05 + 0.9 * 45 / 60, 0.06 + 0.88 * 37 / 50));
}

TEST(CustomerPicture, LayersOfFlatWorkDoNotDarkenOneAnother) {
  // A sheet, and in front of its left half a few points more.
  PointList points;
  for (double x = 10; x <= 50; x += 0.3) {
    for (double z = 10; z <= 40; z += 0.3) points.emplace_back(x, 20.4, z);
  }
  for (double x = 10; x <= 30; x += 1.5) {
    for (double z = 10; z <= 40; z += 1.5) points.emplace_back(x, 20.0, z);
  }
  const Canvas canvas =
      RenderCustomerPicture(points, kPieceBlock, {.longer_side_px = 900});
  const double left = Light(canvas, 0.05 + 0.9 * 20 / 60, 0.5);
  const double right = Light(canvas, 0.05 + 0.9 * 40 / 60, 0.5);
  // 4 % more points.
  EXPECT_GT(left, right);
  EXPECT_LT(left, 1.1 * right);
}

TEST(CustomerPicture, ASolidIsInTheMiddleAndTheGroundIsDarkAroundIt) {
  const Canvas canvas =
      RenderCustomerPicture(Ball(12), kPieceBlock, {.longer_side_px = 500});
  const double middle = Light(canvas, 0.5, 0.5);
  EXPECT_GT(middle, 0.3);
  for (const double x : {0.03, 0.97}) {
    for (const double y : {0.03, 0.97}) EXPECT_LT(Light(canvas, x, y), 0.1 * middle);
  }
}

TEST(CustomerPicture, SmallWorkIsLarge) {
  const auto lit = [](double radius_mm) {
    const Canvas canvas =
        RenderCustomerPicture(Ball(radius_mm), kPieceBlock,
                              {.longer_side_px = 400, .ground = Ground::kTransparent});
    int count = 0;
    for (int y = 0; y < canvas.height(); ++y) {
      for (int x = 0; x < canvas.width(); ++x) count += canvas.at(x, y).b > 0.3F;
    }
    return static_cast<double>(count) / (canvas.width() * canvas.height());
  };
  // A sphere of a twentieth of the block is as large as one of half of it.
  EXPECT_GT(lit(1), 0.03);
  EXPECT_GT(lit(14), 0.03);
}

struct Decoded {
  png_uint_32 width, height;
  bool has_alpha;
  std::vector<std::uint8_t> rgba;

  int alpha(png_uint_32 x, png_uint_32 y) const { return rgba[4 * (y * width + x) + 3]; }
};

Decoded Read(const std::filesystem::path& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, file.c_str()));
  Decoded decoded{
      image.width, image.height, (image.format & PNG_FORMAT_FLAG_ALPHA) != 0, {}};
  image.format = PNG_FORMAT_RGBA;
  decoded.rgba.resize(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, decoded.rgba.data(), 0, nullptr));
  return decoded;
}

TEST(CustomerPicture, OnATransparentGroundOnlyThePieceCovers) {
  const auto file = test::FreshFolder() / "customer.png";
  ASSERT_TRUE(WriteCustomerPicture(
                  file, Ball(12), kPieceBlock,
                  {.longer_side_px = 500, .ground = Ground::kTransparent, .name = ""})
                  .has_value());
  const Decoded picture = Read(file);
  EXPECT_TRUE(picture.has_alpha);
  EXPECT_EQ(picture.alpha(0, 0), 0);
  EXPECT_EQ(picture.alpha(picture.width - 1, picture.height - 1), 0);
  EXPECT_GT(picture.alpha(picture.width / 2, picture.height / 2), 100);
  ASSERT_TRUE(WriteCustomerPicture(file, Ball(12), kPieceBlock, {.longer_side_px = 500})
                  .has_value());
  EXPECT_FALSE(Read(file).has_alpha);
}

TEST(CustomerPicture, TheNameIsBelowThePiece) {
  const Canvas without =
      RenderCustomerPicture(Ball(12), kPieceBlock, {.longer_side_px = 500});
  const Canvas with = RenderCustomerPicture(Ball(12), kPieceBlock,
                                            {.longer_side_px = 500, .name = "MMMM"});
  const auto brightest_below = [](const Canvas& canvas) {
    float brightest = 0;
    for (int y = canvas.height() - 60; y < canvas.height(); ++y) {
      for (int x = canvas.width() / 2 - 60; x < canvas.width() / 2 + 60; ++x) {
        brightest = std::max(brightest, canvas.at(x, y).g);
      }
    }
    return brightest;
  };
  EXPECT_GT(brightest_below(with), 0.6F);
  EXPECT_LT(brightest_below(without), 0.3F);
}

TEST(CustomerPicture, RefusesWhatItCannotDraw) {
  EXPECT_THROW(RenderCustomerPicture({}, Vec3(1, 0, 1), {}), PreconditionError);
  EXPECT_THROW(RenderCustomerPicture({}, kPieceBlock, {.longer_side_px = 100000}),
               PreconditionError);
  EXPECT_NO_THROW(RenderCustomerPicture({}, kPieceBlock, {.longer_side_px = 400}));
  const auto written = WriteCustomerPicture("/no/such/folder/c.png", {}, kPieceBlock,
                                            {.longer_side_px = 400});
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace intaglio::render
