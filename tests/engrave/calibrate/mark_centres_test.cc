// Pictures with marks at known places: discs with soft edges, drawn by sampling each
// pixel 5 x 5 times, before a background that falls off to the corners, with noise.

#include "engrave/calibrate/mark_centres.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace intaglio::calibrate {
namespace {

struct Scene {
  double diameter_px = 8, blur_px = 1, contrast = 0.4, noise = 0.01, vignetting = 0.3;
  bool bright = false;
  double turn_rad = 0.05;
};

struct Photo {
  image::GreyImage picture;
  std::vector<Vec2> centres_px;
};

Photo Draw(const Scene& scene, unsigned seed) {
  constexpr int kSize = 700, kSub = 5;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> jitter(-3, 3);
  std::normal_distribution<double> noise(0, scene.noise);
  Photo photo{{kSize, kSize, std::vector<std::uint16_t>(kSize * kSize)}, {}};
  std::vector<double> covered(kSize * kSize);
  const double c = std::cos(scene.turn_rad), s = std::sin(scene.turn_rad);
  for (int row = -6; row <= 6; ++row) {
    for (int column = -6; column <= 6; ++column) {
      const double u = 45 * column + jitter(random), v = 45 * row + jitter(random);
      const Vec2 at(kSize / 2 + c * u - s * v, kSize / 2 + s * u + c * v);
      photo.centres_px.push_back(at);
      const int reach = static_cast<int>(scene.diameter_px + 5 * scene.blur_px) + 2;
      for (int y = static_cast<int>(at.y()) - reach; y <= at.y() + reach; ++y) {
        for (int x = static_cast<int>(at.x()) - reach; x <= at.x() + reach; ++x) {
          double sum = 0;
          for (int k = 0; k < kSub * kSub; ++k) {
            const Vec2 p(x + (k % kSub + 0.5) / kSub - 0.5,
                         y + (k / kSub + 0.5) / kSub - 0.5);
            const double edge = ((p - at).norm() - scene.diameter_px / 2) / scene.blur_px;
            sum += 0.5 * std::erfc(edge);
          }
          covered[static_cast<std::size_t>(y * kSize + x)] += sum / (kSub * kSub);
        }
      }
    }
  }
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double r = std::hypot(x - kSize / 2, y - kSize / 2) / (kSize / 2);
      const double ground = 0.6 * (1 - scene.vignetting * r * r / 2);
      const double sign = scene.bright ? 0.6 : -1;
      const auto i = static_cast<std::size_t>(y * kSize + x);
      const double light =
          ground * (1 + sign * scene.contrast * std::min(1.0, covered[i])) +
          noise(random);
      photo.picture.samples[i] = static_cast<std::uint16_t>(std::clamp(light, 0.0, 1.0) *
                                                            image::GreyImage::kWhite);
    }
  }
  return photo;
}

/// The root of the mean square distance of the found centres from the true ones, pixels;
/// each true one has to be found once, and nothing else.
double RmsPx(const Scene& scene, unsigned seed, MarkTone tone = MarkTone::kEither) {
  const Photo photo = Draw(scene, seed);
  const auto found = FindMarkCentres(photo.picture, {scene.diameter_px, tone});
  EXPECT_TRUE(found) << found.error().message;
  if (!found) return 1e9;
  EXPECT_EQ(found->size(), photo.centres_px.size());
  double square = 0;
  for (const Vec2& centre : photo.centres_px) {
    double nearest = 1e9;
    for (const Vec2& at : *found) nearest = std::min(nearest, (at - centre).norm());
    EXPECT_LT(nearest, 2);
    square += nearest * nearest;
  }
  return std::sqrt(square / static_cast<double>(photo.centres_px.size()));
}

TEST(MarkCentres, AreFoundToATenthOfAPixel) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const double rms_px = RmsPx({}, seed);
    RecordProperty("rms_px", std::to_string(rms_px));
    EXPECT_LT(rms_px, 0.1);
  }
}

// Blur, noise, a strong fall of light, small and large marks, bright ones.
TEST(MarkCentres, AreFoundInPoorPictures) {
  Scene blurred;
  blurred.blur_px = 2.5;
  EXPECT_LT(RmsPx(blurred, 4), 0.1);
  Scene noisy;
  noisy.noise = 0.025;
  EXPECT_LT(RmsPx(noisy, 5), 0.1);
  Scene dark_corners;
  dark_corners.vignetting = 0.6;  // a quarter of the light
  EXPECT_LT(RmsPx(dark_corners, 6), 0.1);
  Scene large;
  large.diameter_px = 16;
  EXPECT_LT(RmsPx(large, 7), 0.1);
  Scene small;
  small.diameter_px = 5;
  EXPECT_LT(RmsPx(small, 8), 0.1);
  Scene bright;
  bright.bright = true;
  EXPECT_LT(RmsPx(bright, 9), 0.1);
  EXPECT_LT(RmsPx(bright, 10, MarkTone::kBright), 0.1);
}

// Without noise what is left is the method itself.
TEST(MarkCentres, HaveNoBiasOfTheirOwn) {
  Scene clean;
  clean.noise = 0;
  EXPECT_LT(RmsPx(clean, 11), 0.02);
}

TEST(MarkCentres, APictureWithoutMarksIsRefused) {
  Scene empty;
  empty.contrast = 0;
  const Photo photo = Draw(empty, 12);
  const auto found = FindMarkCentres(photo.picture, {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kMissing);
  EXPECT_FALSE(FindMarkCentres(photo.picture, {2}));
  EXPECT_FALSE(FindMarkCentres({10, 10, std::vector<std::uint16_t>(100)}, {}));
}

}  // namespace
}  // namespace intaglio::calibrate
