// Any bytes as the colour profile of a picture: refused with a message, or each pixel has
// its light.

#include <array>
#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/image/icc_light.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  using Colours = image::PixelKind::Colours;
  const std::string_view profile(reinterpret_cast<const char*>(bytes), size);
  std::array<std::uint16_t, 40> pixels{};
  for (std::size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = static_cast<std::uint16_t>(1640 * i);
  for (const image::PixelKind kind :
       {image::PixelKind{Colours::kGrey, false, false},
        image::PixelKind{Colours::kRgb, true, true},
        image::PixelKind{Colours::kInverseCmyk, false, false}}) {
    const auto light = image::IccLight::Open(profile, kind);
    if (!light) {
      Require(!light.error().message.empty(), "an error without a sentence");
      continue;
    }
    std::array<std::uint16_t, 8> row{};
    light->Row(pixels.data(), row.size(), row.data());
  }
  return 0;
}
