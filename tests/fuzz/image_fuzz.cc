#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/image/image_file.h"

// The bytes are read as a photo and as a map of depths: a picture with all of its
// samples, or an error with a sentence.
namespace {

void CheckPicture(std::string_view bytes, intaglio::image::Samples samples) {
  intaglio::image::ImageOptions options;
  options.samples = samples;
  options.background = 0.5;
  options.limits.max_pixels = 1'000'000;  // a header is cheap, rows are not
  options.limits.max_decoder_bytes = 16 << 20;
  const auto image = intaglio::image::ParseImage(bytes, options);
  if (!image) {
    intaglio::Require(!image.error().message.empty(), "an error without a sentence");
    return;
  }
  intaglio::Require(
      image->width > 0 && image->height > 0 &&
          image->samples.size() == static_cast<std::size_t>(image->width) *
                                       static_cast<std::size_t>(image->height),
      "{} samples of {} x {} pixels", image->samples.size(), image->width, image->height);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  CheckPicture(text, intaglio::image::Samples::kLinearLight);
  CheckPicture(text, intaglio::image::Samples::kAsStored);
  return 0;
}
