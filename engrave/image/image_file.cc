#include "engrave/image/image_file.h"

#include <fmt/format.h>

#include "engrave/image/decoders.h"

namespace intaglio::image {

Status CheckSize(std::int64_t width, std::int64_t height, const ImageLimits& limits) {
  if (width <= 0 || height <= 0) {
    return Fail(ErrorCode::kUnreadable, "the picture has no pixels: save it again",
                fmt::format("{} x {}", width, height));
  }
  if (static_cast<std::uint64_t>(width) >
      limits.max_pixels / static_cast<std::uint64_t>(height)) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("the picture has {} x {} pixels, more than the {} allowed: "
                            "make it smaller, or raise the limit",
                            width, height, limits.max_pixels),
                fmt::format("{} x {}", width, height));
  }
  return {};
}

Status CheckDecoder(std::uint64_t needed_bytes, const ImageLimits& limits,
                    std::string_view remedy) {
  if (needed_bytes <= limits.max_decoder_bytes) return {};
  return Fail(ErrorCode::kTooLarge,
              fmt::format("decoding the picture takes {} additional bytes, more than the "
                          "{} allowed: {}, or raise the limit",
                          needed_bytes, limits.max_decoder_bytes, remedy),
              std::to_string(needed_bytes));
}

std::uint16_t* AddRow(GreyImage& image) {
  const auto width = static_cast<std::size_t>(image.width);
  if (image.samples.empty()) {
    image.samples.reserve(width * static_cast<std::size_t>(image.height));
  }
  image.samples.resize(image.samples.size() + width);
  return image.samples.data() + image.samples.size() - width;
}

Result<GreyImage> ParseImage(std::string_view bytes, const ImageOptions& options) {
  if (bytes.size() > options.limits.max_file_bytes) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("the picture's file has {} bytes, more than the {} allowed: "
                            "make it smaller, or raise the limit",
                            bytes.size(), options.limits.max_file_bytes),
                std::to_string(bytes.size()));
  }
  if (bytes.starts_with("BM")) return ParseBmp(bytes, options);
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return ParsePng(bytes, options);
  if (bytes.starts_with("\xff\xd8")) return ParseJpeg(bytes, options);
  if (IsTiff(bytes)) return ParseTiff(bytes, options);
  if (IsPcx(bytes)) return ParsePcx(bytes, options);
  return Fail(ErrorCode::kUnreadable,
              "the file is not a PNG, JPEG, TIFF, BMP or PCX: save the picture in one of "
              "these formats");
}

}  // namespace intaglio::image
