#include "engrave/image/resample.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/engrave/image/pictures.h"

namespace intaglio::image {
namespace {

GreyImage Noise(int width, int height) {
  std::mt19937 random(3);
  GreyImage image{width, height, {}};
  for (int i = 0; i < width * height; ++i) {
    image.samples.push_back(static_cast<std::uint16_t>(random() >> 16));
  }
  return image;
}

/// Mean over a rectangle in pixels, summed in doubles over all pixels it touches.
double MeanOver(const GreyImage& image, double x0, double y0, double x1, double y1) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double w = std::max(0.0, std::min(x + 1.0, x1) - std::max(x + 0.0, x0));
      const double h = std::max(0.0, std::min(y + 1.0, y1) - std::max(y + 0.0, y0));
      sum += w * h * image.at(x, y) / 65535.0;
    }
  }
  return sum / ((x1 - x0) * (y1 - y0));
}

TEST(Resample, AreaIsTheMeanOfWhatANewPixelCovers) {
  const GreyImage image = Noise(97, 61);
  const FloatImage small = Resample(image, 13, 17);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 13; ++x) {
      const double expected = MeanOver(image, x * 97 / 13.0, y * 61 / 17.0,
                                       (x + 1) * 97 / 13.0, (y + 1) * 61 / 17.0);
      EXPECT_NEAR(small.at(x, y), expected, 1e-5);  // float sums of some 30 values
    }
  }
}

TEST(Resample, AWindowTakesItsPart) {
  const GreyImage image = Noise(80, 40);
  const FloatImage part = Resample(image, 5, 5, Filter::kArea, {0.25, 0.5, 0.75, 1});
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(part.at(i, 2), MeanOver(image, 20 + 8 * i, 28, 28 + 8 * i, 32), 1e-5);
  }
}

TEST(Resample, OutsideTheBorderGoesOn) {
  const GreyImage image = PaintGrey(4, 1, [](int x, int) { return x == 0 ? 0.75 : 0.0; });
  const FloatImage wide = Resample(image, 4, 1, Filter::kArea, {-1, 0, 1, 1});
  EXPECT_NEAR(wide.at(0, 0), 0.75, 1e-4);
  EXPECT_NEAR(wide.at(1, 0), 0.75, 1e-4);
  EXPECT_NEAR(wide.at(3, 0), 0, 1e-4);
}

TEST(Resample, BothFiltersKeepARampAndAConstant) {
  const GreyImage ramp = PaintGrey(64, 8, [](int x, int) { return (x + 0.5) / 64; });
  for (const Filter filter : {Filter::kArea, Filter::kLanczos}) {
    for (const int width : {16, 29, 64, 200}) {
      const FloatImage image = Resample(ramp, width, 8, filter);
      for (int x = width / 4; x < 3 * width / 4; ++x) {
        // Steps of 1/64 under a box, at most an eighth of a step; the lobes of Lanczos
        // do not add up to the same everywhere.
        EXPECT_NEAR(image.at(x, 4), (x + 0.5) / width,
                    filter == Filter::kArea ? 2e-3 : 4e-3)
            << width;
      }
    }
    const GreyImage even = PaintGrey(10, 10, [](int, int) { return 0.3; });
    for (const float value : Resample(even, 7, 23, filter).values) {
      EXPECT_NEAR(value, 0.3, 1e-4);
    }
  }
}

TEST(Resample, LanczosIsSharperAndStaysWithinBlackAndWhite) {
  const GreyImage edge = PaintGrey(64, 4, [](int x, int) { return x < 33 ? 0.0 : 1.0; });
  const FloatImage area = Resample(edge, 200, 4, Filter::kArea);
  const FloatImage lanczos = Resample(edge, 200, 4, Filter::kLanczos);
  float area_step = 0, lanczos_step = 0;
  for (int x = 1; x < 200; ++x) {
    area_step = std::max(area_step, area.at(x, 2) - area.at(x - 1, 2));
    lanczos_step = std::max(lanczos_step, lanczos.at(x, 2) - lanczos.at(x - 1, 2));
    EXPECT_GE(lanczos.at(x, 2), 0);
    EXPECT_LE(lanczos.at(x, 2), 1);
  }
  EXPECT_GT(lanczos_step, area_step);
}

TEST(Interpolate, FollowsStraightLinesBetweenCentres) {
  FloatImage image{3, 2, {0, 0.5, 1, 1, 1, 1}};
  EXPECT_NEAR(Interpolate(image, 0.5, 0.25), 0.5, 1e-6);
  EXPECT_NEAR(Interpolate(image, 1 / 3.0, 0.25), 0.25, 1e-6);
  EXPECT_NEAR(Interpolate(image, 0.5, 0.5), 0.75, 1e-6);
  EXPECT_NEAR(Interpolate(image, -2, -2), 0, 1e-6);
  EXPECT_NEAR(Interpolate(image, 2, 0), 1, 1e-6);
}

}  // namespace
}  // namespace intaglio::image
