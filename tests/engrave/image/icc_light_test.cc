#include "engrave/image/icc_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcms2.h>
#include <zlib.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <string>

#include "engrave/image/image_file.h"
#include "tests/engrave/image/pictures.h"

namespace intaglio::image {
namespace {

using ::testing::HasSubstr;

// Adobe RGB (1998): a wider triangle of colours, and a pure power.
constexpr double kGamma = 563.0 / 256;
constexpr std::array<std::array<double, 2>, 3> kPrimaries = {
    {{0.64, 0.33}, {0.21, 0.71}, {0.15, 0.06}}};
constexpr std::array<double, 2> kD65 = {0.3127, 0.3290};

std::string BytesOf(cmsHPROFILE profile) {
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  return bytes;
}

std::string WideProfile() {
  const cmsCIExyY white = {kD65[0], kD65[1], 1};
  cmsCIExyYTRIPLE primaries{};
  std::array<cmsCIExyY*, 3> at = {&primaries.Red, &primaries.Green, &primaries.Blue};
  for (std::size_t i = 0; i < 3; ++i) *at[i] = {kPrimaries[i][0], kPrimaries[i][1], 1};
  cmsToneCurve* power = cmsBuildGamma(nullptr, kGamma);
  cmsToneCurve* const curves[] = {power, power, power};
  const cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves);
  cmsFreeToneCurve(power);
  return BytesOf(profile);
}

/// The luminance of the primaries at full light, by their chromaticities and that of
/// white: X = x / y, Y = 1, Z = (1 - x - y) / y, scaled so that they add up to white.
Eigen::Vector3d LuminanceOfPrimaries() {
  const auto xyz = [](const std::array<double, 2>& xy) {
    return Eigen::Vector3d(xy[0] / xy[1], 1, (1 - xy[0] - xy[1]) / xy[1]);
  };
  Eigen::Matrix3d all;
  for (int i = 0; i < 3; ++i) all.col(i) = xyz(kPrimaries[static_cast<std::size_t>(i)]);
  return all.inverse() * xyz(kD65);
}

double WideLuminanceOf(const Rgb& c) {
  const auto light = [](int byte) { return std::pow(byte / 255.0, kGamma); };
  return LuminanceOfPrimaries().dot(Eigen::Vector3d(light(c.r), light(c.g), light(c.b)));
}

void AppendBigEndian(std::size_t value, std::string& to) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    to.push_back(static_cast<char>(value >> shift & 255U));
  }
}

/// PNG specification 11.3.3.3: a name, the method, the deflated profile; behind IHDR.
std::string PngWith(std::string png, const std::string& profile) {
  uLongf size = compressBound(profile.size());
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(profile.data()), profile.size());
  packed.resize(size);
  const std::string body = std::string("iCCPtest\0\0", 10) + packed;
  std::string chunk;
  AppendBigEndian(body.size() - 4, chunk);
  chunk += body;
  AppendBigEndian(crc32(0, reinterpret_cast<const Bytef*>(body.data()),
                        static_cast<uInt>(body.size())),
                  chunk);
  return png.insert(33, chunk);
}

/// ICC.1:2010 B.4, in one marker behind SOI.
std::string JpegWith(std::string jpeg, const std::string& profile) {
  const std::size_t size = 2 + 14 + profile.size();
  std::string marker = "\xff\xe2";
  marker.push_back(static_cast<char>(size >> 8));
  marker.push_back(static_cast<char>(size & 255U));
  marker += std::string("ICC_PROFILE\0\1\1", 14) + profile;
  return jpeg.insert(2, marker);
}

Rgb PaintedIcc(int x, int y) {
  return {static_cast<std::uint8_t>(17 * x), static_cast<std::uint8_t>(23 * y),
          static_cast<std::uint8_t>(5 * x + 7 * y)};
}

// A profile has 16 bits behind the point: 1e-4 of white, 7 of 65535.
constexpr double kRounding = 10;

TEST(IccLight, APictureHasTheLightOfItsProfile) {
  const std::string plain = EncodePng(16, 11, PaintedIcc);
  const auto image = ParseImage(PngWith(plain, WideProfile()));
  ASSERT_TRUE(image) << image.error().message;
  double farthest = 0;
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 16; ++x) {
      const Rgb c = PaintedIcc(x, y);
      EXPECT_NEAR(image->at(x, y), 65535 * WideLuminanceOf(c), kRounding);
      farthest = std::max(farthest, std::abs(WideLuminanceOf(c) - LuminanceOf(c)));
    }
  }
  EXPECT_GT(65535 * farthest, 100 * kRounding) << "the profile makes a difference";
}

TEST(IccLight, AProfileOfSrgbChangesNothing) {
  const std::string plain = EncodePng(16, 11, PaintedIcc);
  const auto without = ParseImage(plain);
  const auto with = ParseImage(PngWith(plain, BytesOf(cmsCreate_sRGBProfile())));
  ASSERT_TRUE(with) << with.error().message;
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 16; ++x) {
      EXPECT_NEAR(with->at(x, y), without->at(x, y), kRounding);
    }
  }
}

TEST(IccLight, GreyPixelsGetTheirCurveAndTransparentOnesTheirBackground) {
  cmsToneCurve* power = cmsBuildGamma(nullptr, 3.0);
  const cmsCIExyY white = *cmsD50_xyY();
  const std::string grey = BytesOf(cmsCreateGrayProfile(&white, power));
  cmsFreeToneCurve(power);
  PngKind kind;
  kind.color_type = PNG_COLOR_TYPE_GRAY_ALPHA;
  const std::string png =
      PngWith(EncodePng(3, 1, {{128, 255, 200, 0, 64, 128}}, kind), grey);
  const auto image = ParseImage(png);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_NEAR(image->at(0, 0), 65535 * std::pow(128 / 255.0, 3), kRounding);
  EXPECT_EQ(image->at(1, 0), 65535);
  const double light = std::pow(64 / 255.0, 3), share = 128 / 255.0;
  EXPECT_NEAR(image->at(2, 0), 65535 * (share * light + 1 - share), kRounding);
  ImageOptions depths;
  depths.samples = Samples::kAsStored;
  EXPECT_EQ(ParseImage(png, depths)->at(1, 0), 65535) << "not of values as stored";
}

TEST(IccLight, JpegAndItsGreyByAProfileOfRgb) {
  JpegKind kind;
  const auto flat = [](int, int) { return Rgb{200, 60, 120}; };
  auto image = ParseImage(JpegWith(EncodeJpeg(8, 8, flat, kind), WideProfile()));
  ASSERT_TRUE(image) << image.error().message;
  // Two steps of 255 are lost by the colours of JPEG.
  EXPECT_NEAR(image->at(4, 4), 65535 * WideLuminanceOf({200, 60, 120}), 600);
  kind.grey = true;
  const auto middle = [](int, int) { return Rgb{128, 128, 128}; };
  image = ParseImage(JpegWith(EncodeJpeg(8, 8, middle, kind), WideProfile()));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_NEAR(image->at(4, 4), 65535 * std::pow(128 / 255.0, kGamma), kRounding);
}

// Found by a fuzzer: a number of colours that lcms2 has no name for.
TEST(IccLight, UnknownColoursAreAnErrorWithItsRemedy) {
  std::string profile = WideProfile();
  profile.replace(16, 4, 4, '\xff');  // data colour space (ICC.1:2010, 7.2.8)
  const auto light = IccLight::Open(profile, {PixelKind::Colours::kRgb, false, false});
  ASSERT_FALSE(light.has_value());
  EXPECT_THAT(light.error().message,
              HasSubstr("is of unknown colours and the picture of RGB"));
}

TEST(IccLight, ADamagedProfileIsAnErrorWithItsRemedy) {
  const std::string plain = EncodePng(4, 4, PaintedIcc), profile = WideProfile();
  const auto error_of = [](const std::string& file) {
    const auto image = ParseImage(file);
    EXPECT_FALSE(image);
    return image ? std::string() : image.error().message;
  };
  EXPECT_THAT(error_of(PngWith(plain, profile.substr(0, 100))),
              HasSubstr("save the picture as sRGB"));
  std::string no_red = profile;  // what libpng checks is right
  no_red.replace(no_red.find("rXYZ"), 4, "xXYZ");
  EXPECT_THAT(error_of(PngWith(plain, no_red)), HasSubstr("ICC profile"));
  const std::string jpeg = EncodeJpeg(8, 8, PaintedIcc);
  EXPECT_THAT(error_of(JpegWith(jpeg, "no profile at all")), HasSubstr("is damaged"));
  cmsToneCurve* line = cmsBuildGamma(nullptr, 1.0);
  const cmsCIExyY white = *cmsD50_xyY();
  const std::string grey = BytesOf(cmsCreateGrayProfile(&white, line));
  cmsFreeToneCurve(line);
  EXPECT_THAT(error_of(JpegWith(jpeg, grey)),
              HasSubstr("is of GRAY colours and the picture of RGB"));
  for (std::size_t at = 0; at < profile.size(); at += 3) {  // no crash, any outcome
    std::string damaged = profile;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    (void)ParseImage(JpegWith(jpeg, damaged));
  }
}

}  // namespace
}  // namespace intaglio::image
