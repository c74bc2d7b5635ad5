#include "engrave/discretize/picture/halftone.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "tests/engrave/image/pictures.h"

namespace intaglio::discretize {
namespace {

using image::GreyImage;
using image::PaintGrey;

const HalftoneMethod kTonal[] = {HalftoneMethod::kErrorDiffusion,
                                 HalftoneMethod::kBlueNoise};

HalftoneOptions Options(HalftoneMethod method, double width_mm, double distance_mm) {
  HalftoneOptions options;
  options.method = method;
  options.size.width_mm = width_mm;
  options.vertex_distance_mm = distance_mm;
  return options;
}

PointList PointsOf(const GreyImage& picture, const HalftoneOptions& options,
                   const mesh::GlassFromModel& placement = {}) {
  const auto source = MakeHalftone(picture, placement, options);
  EXPECT_TRUE(source) << source.error().message;
  SpacedCloud cloud;
  if (source) {
    EXPECT_TRUE((*source)->AddPoints({}, 0, {}, cloud));
  }
  return cloud.points_mm;
}

/// Points per mm^2 of white, by the header's definition.
double Densest(const HalftoneOptions& options) {
  const double d = options.vertex_distance_mm;
  return (options.method == HalftoneMethod::kBlueNoise ? 2 / std::sqrt(3.0) : 1) /
         (d * d);
}

std::size_t CountIn(const PointList& points, double x0, double y0, double x1, double y1) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [&](const Vec3& p) {
        return p.x() >= x0 && p.x() < x1 && p.y() >= y0 && p.y() < y1;
      }));
}

/// Distances to the nearest other point, each against each.
std::vector<double> NearestDistances(const PointList& points) {
  std::vector<double> nearest(points.size(), 1e9);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double square = (points[i] - points[j]).squaredNorm();
      nearest[i] = std::min(nearest[i], square);
      nearest[j] = std::min(nearest[j], square);
    }
  }
  for (double& distance : nearest) distance = std::sqrt(distance);
  return nearest;
}

class HalftoneTone : public testing::TestWithParam<HalftoneMethod> {};
INSTANTIATE_TEST_SUITE_P(Methods, HalftoneTone, testing::ValuesIn(kTonal));

TEST_P(HalftoneTone, OfPatchesFollowsLuminance) {
  const HalftoneMethod method = GetParam();
  const HalftoneOptions options = Options(method, 20, 0.1);
  for (const double tone : {0.05, 0.1, 0.3, 0.5, 0.72, 0.9, 1.0}) {
    const PointList points =
        PointsOf(PaintGrey(50, 50, [&](int, int) { return tone; }), options);
    const double expected = tone * 400 * Densest(options);
    // Whole columns and rows: less than 0.5 % here.
    EXPECT_NEAR(static_cast<double>(points.size()), expected, 0.015 * expected);
    // And within the patch, away from its border.
    const double inner = tone * 100 * Densest(options);
    EXPECT_NEAR(static_cast<double>(CountIn(points, 5, 5, 15, 15)), inner, 0.02 * inner)
        << "method " << static_cast<int>(method) << " tone " << tone;
  }
}

TEST_P(HalftoneTone, OfARampFollowsLuminance) {
  // 0 to 1 along x: strips against the integral of the ramp over them.
  const GreyImage ramp =
      PaintGrey(1000, 500, [](int x, int) { return (x + 0.5) / 1000; });
  const HalftoneMethod method = GetParam();
  const HalftoneOptions options = Options(method, 40, 0.1);
  const PointList points = PointsOf(ramp, options);
  for (int strip = 1; strip < 10; ++strip) {
    const double expected = (strip + 0.5) / 10 * 4 * 20 * Densest(options);
    const auto count =
        static_cast<double>(CountIn(points, 4 * strip, 0, 4 * strip + 4, 20));
    EXPECT_NEAR(count, expected, 0.02 * expected)
        << "method " << static_cast<int>(method) << " strip " << strip;
  }
}

TEST(Halftone, AWaveKeepsItsAmplitude) {
  // The first Fourier coefficient of the points against that of the brightness
  // 0.5 + 0.4 cos(2 pi x / 2 mm): detail is neither lost nor added.
  const GreyImage wave = PaintGrey(1000, 500, [](int x, int) {
    return 0.5 + 0.4 * std::cos(2 * M_PI * (x + 0.5) / 100);
  });
  for (const HalftoneMethod method : kTonal) {
    const PointList points = PointsOf(wave, Options(method, 20, 0.1));
    double sum = 0;
    for (const Vec3& p : points) sum += std::cos(2 * M_PI * p.x() / 2);
    // Error diffusion sharpens a little (its known property).
    EXPECT_NEAR(2 * sum / static_cast<double>(points.size()), 0.8, 0.05);
  }
}

TEST(Halftone, NoPointsAreNearerThanTheVertexDistance) {
  const GreyImage picture = PaintGrey(80, 60, [](int x, int y) {
    return std::abs(std::sin(0.11 * x) * std::cos(0.07 * y)) * (x / 20 % 2 ? 1 : 0.3);
  });
  for (const HalftoneMethod method : {HalftoneMethod::kThreshold, kTonal[0], kTonal[1]}) {
    for (const int layers : {1, 3}) {
      HalftoneOptions options = Options(method, 8.03, 0.1);
      options.layer_count = layers;
      options.layer_distance_mm = 0.1;
      options.tone.brightness = layers == 3 ? 0.3 : 0;
      mesh::GlassFromModel placement;
      placement.linear =
          Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix() *
          Vec3(1.1, 0.8, 3).asDiagonal();
      placement.offset_mm = Vec3(50, 40, 30);
      const PointList points = PointsOf(picture, options, placement);
      ASSERT_GT(points.size(), 500U);
      const auto nearest = NearestDistances(points);
      EXPECT_GE(*std::min_element(nearest.begin(), nearest.end()), 0.1)
          << "method " << static_cast<int>(method) << " layers " << layers;
    }
  }
}

TEST(Halftone, BlueNoiseIsEven) {
  // The coefficient of variation of the nearest distance is 0.52 for points thrown at
  // random, some 0.08 for Poisson discs of the best peers (which have one density only).
  for (const double tone : {0.05, 0.15, 0.3, 0.5}) {
    HalftoneOptions options = Options(HalftoneMethod::kBlueNoise, 10, 0.1);
    const GreyImage grey = PaintGrey(20, 20, [&](int, int) { return tone; });
    const PointList points = PointsOf(grey, options);
    const auto nearest = NearestDistances(points);
    const double mean = std::accumulate(nearest.begin(), nearest.end(), 0.0) /
                        static_cast<double>(nearest.size());
    double square = 0;
    for (const double d : nearest) square += (d - mean) * (d - mean);
    const double variation =
        std::sqrt(square / static_cast<double>(nearest.size())) / mean;
    RecordProperty("variation", std::to_string(variation));
    EXPECT_LT(variation, 0.12) << tone;
    // Blue: below half the principal frequency there is less than a tenth of the power
    // that points thrown at random have (1).
    const double principal = std::sqrt(static_cast<double>(points.size()) / 100);
    double power = 0;
    int count = 0;
    const int last = static_cast<int>(5 * principal);
    for (int u = 0; u <= last; u += 3) {
      for (int v = 1; v <= last; v += 3) {
        if (std::hypot(u, v) > last) continue;
        double re = 0, im = 0;
        for (const Vec3& p : points) {
          const double phase = 2 * M_PI * (u * p.x() + v * p.y()) / 10;
          re += std::cos(phase), im += std::sin(phase);
        }
        power += (re * re + im * im) / static_cast<double>(points.size());
        ++count;
      }
    }
    RecordProperty("power", std::to_string(power / count));
    EXPECT_LT(power / count, 0.1) << tone;
  }
}

TEST(Halftone, LayersTakeWhatIsBeyondTheFirstAndAreStaggered) {
  const GreyImage ramp = PaintGrey(400, 100, [](int x, int) { return (x + 0.5) / 400; });
  for (const HalftoneMethod method : kTonal) {
    for (const LayerSharing sharing : {LayerSharing::kOverflow, LayerSharing::kEven}) {
      HalftoneOptions options = Options(method, 16, 0.1);
      options.layer_count = 3;
      options.layer_distance_mm = 0.7;
      options.sharing = sharing;
      const PointList points = PointsOf(ramp, options);
      const double all = 0.5 * 16 * 4 * 3 * Densest(options);
      EXPECT_NEAR(static_cast<double>(points.size()), all, 0.02 * all);
      for (const Vec3& p : points) {
        EXPECT_NEAR(p.z() / 0.7, std::round(p.z() / 0.7), 1e-9);
      }
      const bool third_is_dark =
          std::none_of(points.begin(), points.end(),
                       [](const Vec3& p) { return p.z() > 1 && p.x() < 10; });
      EXPECT_EQ(third_is_dark, sharing == LayerSharing::kOverflow);
      PointList above = points;
      for (Vec3& p : above) p.z() = 0;
      const auto nearest = NearestDistances(above);
      EXPECT_GT(*std::min_element(nearest.begin(), nearest.end()), 0.1 / 6)
          << "seen from above";
    }
  }
}

TEST(Halftone, ATargetCountIsMet) {
  const GreyImage picture =
      PaintGrey(300, 200, [](int x, int y) { return std::pow((x + y) / 500.0, 2); });
  for (const HalftoneMethod method : kTonal) {
    for (const std::uint64_t target : {3000U, 15000U, 40000U}) {
      HalftoneOptions options = Options(method, 20, 0.1);
      options.layer_count = 2;
      options.target_point_count = target;
      const auto count = static_cast<double>(PointsOf(picture, options).size());
      EXPECT_NEAR(count, static_cast<double>(target), 0.01 * static_cast<double>(target));
    }
  }
  HalftoneOptions options = Options(HalftoneMethod::kThreshold, 20, 0.1);
  options.threshold = 0.5;
  options.target_point_count = 2000;
  EXPECT_NEAR(static_cast<double>(PointsOf(picture, options).size()), 2000, 60);
}

TEST(Halftone, AThresholdTakesWhatIsBrighter) {
  const GreyImage picture =
      PaintGrey(40, 40, [](int x, int y) { return x < 20 ? 0.0 : (y < 10 ? 0.2 : 0.9); });
  HalftoneOptions options = Options(HalftoneMethod::kThreshold, 4, 0.1);
  options.threshold = 0.6;  // linear 0.319
  const PointList points = PointsOf(picture, options);
  EXPECT_EQ(points.size(), 20U * 30U);  // row 0 of the picture is on top: y from 3 up
  EXPECT_EQ(CountIn(points, 2, 0, 4, 3), points.size());
  options.tone.invert = true;
  EXPECT_EQ(CountIn(PointsOf(picture, options), 0, 0, 2, 4), 20U * 40U);
}

TEST(Halftone, TheSizeFollowsItsRule) {
  GreyImage picture = PaintGrey(40, 20, [](int, int) { return 1.0; });
  const auto size = [&](PanelSize::Rule rule, double width, double height) {
    return PanelSizeOf(picture, {rule, width, height}, 0.25).value();
  };
  EXPECT_EQ(size(PanelSize::Rule::kGiven, 10, 0), Vec2(10, 5));
  EXPECT_EQ(size(PanelSize::Rule::kGiven, 0, 10), Vec2(20, 10));
  EXPECT_EQ(size(PanelSize::Rule::kGiven, 3, 9), Vec2(3, 9));
  EXPECT_EQ(size(PanelSize::Rule::kFit, 10, 10), Vec2(10, 5));
  EXPECT_EQ(size(PanelSize::Rule::kFit, 90, 10), Vec2(20, 10));
  EXPECT_EQ(size(PanelSize::Rule::kPixel, 0, 0), Vec2(10, 5));
  EXPECT_EQ(PanelSizeOf(picture, {}, 0.25).error().code, ErrorCode::kMissing);
  EXPECT_EQ(PanelSizeOf(picture, {PanelSize::Rule::kGiven, -1, 0}, 0.25).error().code,
            ErrorCode::kInvalidValue);
}

TEST(Halftone, ThePlacementTurnsAndScalesThePanelNotItsSpacing) {
  const GreyImage white = PaintGrey(10, 10, [](int, int) { return 1.0; });
  HalftoneOptions options = Options(HalftoneMethod::kErrorDiffusion, 2, 0.1);
  options.layer_count = 2;
  mesh::GlassFromModel placement;  // up becomes z, twice as large, layers along -y
  placement.linear << 2, 0, 0, 0, 0, -2, 0, 2, 0;
  placement.offset_mm = Vec3(10, 20, 30);
  const PointList points = PointsOf(white, options, placement);
  EXPECT_NEAR(static_cast<double>(points.size()), 2 * 40 * 40, 2 * 80);
  for (const Vec3& p : points) {
    EXPECT_GE(p.x(), 10);
    EXPECT_LE(p.x(), 14);
    EXPECT_GE(p.z(), 30);
    EXPECT_LE(p.z(), 34);
    EXPECT_TRUE(std::abs(p.y() - 20) < 1e-12 || std::abs(p.y() - 19) < 1e-12);
  }
  placement.linear(0, 1) = 0.5;
  EXPECT_EQ(MakeHalftone(white, placement, options).error().code,
            ErrorCode::kInvalidValue);
}

TEST(Halftone, TheSameSeedGivesTheSamePointsInEveryCutByHeight) {
  const GreyImage picture =
      PaintGrey(30, 30, [](int x, int y) { return (x * y % 30) / 30.0; });
  HalftoneOptions options = Options(HalftoneMethod::kBlueNoise, 5, 0.1);
  const PointList once = PointsOf(picture, options), again = PointsOf(picture, options);
  EXPECT_EQ(once, again);
  options.seed = 2;
  EXPECT_NE(once, PointsOf(picture, options));
}

TEST(Halftone, OptionsOutsideTheirRangesAreReported) {
  HalftoneOptions options = Options(HalftoneMethod::kBlueNoise, 5, 0.001);
  options.threshold = 2;
  options.layer_count = 11;
  options.layer_distance_mm = 60;
  options.settle_count = -1;
  options.tone.gamma = 0;
  EXPECT_EQ(CheckHalftone(options).size(), 6U);
  options = Options(HalftoneMethod::kBlueNoise, 5, 0.1);
  EXPECT_TRUE(CheckHalftone(options).empty());
  options.layer_count = 2;
  options.layer_distance_mm = 0.09;
  ASSERT_EQ(CheckHalftone(options).size(), 1U);
  EXPECT_NE(CheckHalftone(options)[0].message.find("thinning"), std::string::npos);
  options = Options(HalftoneMethod::kBlueNoise, 1000, 0.01);
  const GreyImage white = PaintGrey(1, 1, [](int, int) { return 1.0; });
  EXPECT_EQ(MakeHalftone(white, {}, options).error().code, ErrorCode::kTooLarge);
}

TEST(Halftone, ToneCurvesActOnTheScaleOfEditors) {
  ToneCurve tone;
  EXPECT_TRUE(tone.IsIdentity());
  tone.invert = true;
  EXPECT_NEAR(ApplyTone(tone, 0.3), 0.7, 1e-12);
  tone = {};
  tone.contrast_ratio = 2;
  tone.brightness = 0.1;
  EXPECT_NEAR(ApplyTone(tone, 0.5), 0.7, 1e-12);
  EXPECT_NEAR(ApplyTone(tone, 0.9), 1, 1e-12);
  tone = {};
  tone.gamma = 2;
  EXPECT_NEAR(ApplyTone(tone, 0.25), 0.5, 1e-12);
  tone = {};
  tone.points = {{0.2, 0}, {0.6, 0.8}};
  EXPECT_NEAR(ApplyTone(tone, 0.1), 0, 1e-12);
  EXPECT_NEAR(ApplyTone(tone, 0.3), 0.2, 1e-12);
  EXPECT_NEAR(ApplyTone(tone, 0.7), 0.8, 1e-12);
  EXPECT_TRUE(CheckTone(tone));
  tone.points = {{0.6, 0}, {0.2, 0.8}};
  EXPECT_FALSE(CheckTone(tone));
}

}  // namespace
}  // namespace intaglio::discretize
