#include "engrave/image/icc_light.h"

#include <fmt/format.h>
#include <lcms2.h>

#include <algorithm>
#include <array>
#include <cmath>

// The profile's colours become linear light of the primaries of ITU-R BT.709, and these
// their luminance, so that a profile of sRGB gives what a picture without one gives.

namespace intaglio::image {
namespace {

using IccColours = PixelKind::Colours;

struct CloseProfile {
  void operator()(void* profile) const { cmsCloseProfile(profile); }
};
using Profile = std::unique_ptr<void, CloseProfile>;

Profile LinearBt709() {
  const cmsCIExyY white = {0.3127, 0.3290, 1};
  const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1}, {0.30, 0.60, 1}, {0.15, 0.06, 1}};
  cmsToneCurve* const line = cmsBuildGamma(nullptr, 1.0);
  cmsToneCurve* const curves[] = {line, line, line};
  Profile profile(cmsCreateRGBProfile(&white, &primaries, curves));
  cmsFreeToneCurve(line);
  return profile;
}

unsigned ChannelsOf(IccColours colours) {
  if (colours == IccColours::kGrey) return 1;
  return colours == IccColours::kRgb ? 3 : 4;
}

cmsUInt32Number FormatOf(const PixelKind& kind) {
  const unsigned space = kind.colours == IccColours::kGrey  ? PT_GRAY
                         : kind.colours == IccColours::kRgb ? PT_RGB
                                                            : PT_CMYK;
  const bool flips = kind.colours == IccColours::kInverseCmyk;
  return COLORSPACE_SH(space) | CHANNELS_SH(ChannelsOf(kind.colours)) |
         EXTRA_SH(kind.alpha ? 1 : 0) | BYTES_SH(kind.wide ? 2 : 1) |
         FLAVOR_SH(flips ? 1 : 0);
}

/// A profile may have any number there, which its enumeration has not.
cmsUInt32Number SpaceOf(IccColours colours) {
  if (colours == IccColours::kGrey) return cmsSigGrayData;
  return colours == IccColours::kRgb ? cmsSigRgbData : cmsSigCmykData;
}

/// "RGB", of four characters.
std::string SpaceName(cmsUInt32Number space) {
  std::string name;
  for (int shift = 24; shift >= 0; shift -= 8) {
    const char c = static_cast<char>(space >> shift & 255U);
    if (c > ' ' && c < 127) name.push_back(c);
  }
  return name.empty() ? "unknown" : name;
}

tl::unexpected<Error> Bad(std::string_view what) {
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("the ICC profile in the picture {}: save the picture as sRGB, or "
                  "without a profile",
                  what));
}

}  // namespace

void IccLight::Close::operator()(void* transform) const { cmsDeleteTransform(transform); }

Result<IccLight> IccLight::Open(std::string_view bytes, const PixelKind& kind) {
  const Profile profile(
      cmsOpenProfileFromMem(bytes.data(), static_cast<cmsUInt32Number>(bytes.size())));
  if (!profile) return Bad("is damaged");
  IccLight light;
  light.kind_ = kind;
  const auto space = static_cast<cmsUInt32Number>(cmsGetColorSpace(profile.get()));
  light.grey_by_rgb_ = kind.colours == IccColours::kGrey && space == cmsSigRgbData;
  if (light.grey_by_rgb_) {
    light.kind_ = {.colours = IccColours::kRgb, .alpha = false, .wide = true};
  } else if (space != SpaceOf(kind.colours)) {
    return Bad(fmt::format("is of {} colours and the picture of {}", SpaceName(space),
                           SpaceName(SpaceOf(kind.colours))));
  }
  light.transform_.reset(cmsCreateTransform(
      profile.get(), FormatOf(light.kind_), LinearBt709().get(), TYPE_RGB_FLT,
      INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOCACHE | cmsFLAGS_NOOPTIMIZE));
  if (!light.transform_) return Bad("has no way to its colours");
  light.kind_ = kind;
  return light;
}

void IccLight::Row(const void* pixels, std::size_t count, std::uint16_t* light) const {
  if (!grey_by_rgb_) return Convert(pixels, count, light);
  triples_.resize(3 * count);
  const std::size_t step = kind_.alpha ? 2 : 1;
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned grey = kind_.wide
                              ? static_cast<const std::uint16_t*>(pixels)[step * i]
                              : 257U * static_cast<const std::uint8_t*>(pixels)[step * i];
    std::fill_n(triples_.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                static_cast<std::uint16_t>(grey));
  }
  Convert(triples_.data(), count, light);
}

void IccLight::Convert(const void* pixels, std::size_t count,
                       std::uint16_t* light) const {
  linear_.resize(3 * count);
  cmsDoTransform(transform_.get(), pixels, linear_.data(),
                 static_cast<cmsUInt32Number>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const float* c = linear_.data() + 3 * i;
    const double y = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    // A damaged table may give what is no number.
    light[i] = y > 0 ? static_cast<std::uint16_t>(std::lround(65535 * std::min(y, 1.0)))
                     : std::uint16_t{0};
  }
}

}  // namespace intaglio::image
