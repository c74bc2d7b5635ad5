#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <limits>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/image/decoders.h"
#include "engrave/image/luminance.h"

// Windows bitmaps ([MS-WMF] 2.2.2): a file header of 14 bytes (at 10: where the pixels
// begin), a header of 12 bytes (OS/2) or of 40 and more, up to three bit masks, a palette
// of 3 or 4 bytes an entry, rows from the bottom up (from the top down when the height is
// negative), each filled up to 4 bytes. Numbers are little-endian.

namespace intaglio::image {
namespace {

constexpr std::size_t kFileHeader = 14;
enum Compression : std::uint32_t {
  kPlain = 0,
  kRle8 = 1,
  kRle4 = 2,
  kBitFields = 3,
  kAlphaBitFields = 6,
};

/// One channel of a pixel of 16 or 32 bits.
struct Mask {
  std::uint32_t bits = 0;

  /// 0..255; `absent` when the mask is empty.
  unsigned Of(std::uint32_t pixel, unsigned absent) const {
    if (bits == 0) return absent;
    const std::uint64_t top = bits >> std::countr_zero(bits);
    return static_cast<unsigned>(
        (std::uint64_t{(pixel & bits) >> std::countr_zero(bits)} * 255 + top / 2) / top);
  }
};

struct Bitmap {
  std::string_view bytes;
  std::int64_t width = 0, height = 0;
  bool top_down = false;
  unsigned depth = 0;  // bits a pixel
  std::uint32_t compression = kPlain;
  std::size_t palette_at = 0, palette_count = 0, palette_step = 4;
  Mask red, green, blue, alpha;
  std::size_t pixels_at = 0;

  bool Has(std::size_t at, std::size_t size) const {
    return at <= bytes.size() && bytes.size() - at >= size;
  }
  unsigned U8(std::size_t at) const { return static_cast<std::uint8_t>(bytes[at]); }
  unsigned U16(std::size_t at) const { return U8(at) | U8(at + 1) << 8; }
  std::uint32_t U32(std::size_t at) const { return U16(at) | U16(at + 2) << 16; }
};

tl::unexpected<Error> CutOff(std::string_view what) {
  return Fail(ErrorCode::kUnreadable,
              fmt::format("the BMP ends within {}: copy or save it again", what));
}

Status ReadMasks(Bitmap& b, std::uint32_t header_size) {
  if (b.depth != 16 && b.depth != 32) return {};
  if (b.compression == kPlain) {
    b.red.bits = b.depth == 16 ? 0x7C00U : 0xFF0000U;
    b.green.bits = b.depth == 16 ? 0x03E0U : 0xFF00U;
    b.blue.bits = b.depth == 16 ? 0x001FU : 0xFFU;
    return {};
  }
  constexpr std::size_t kMasks = kFileHeader + 40;  // behind or within the header
  const bool with_alpha = header_size >= 56 || b.compression == kAlphaBitFields;
  if (!b.Has(kMasks, with_alpha ? 16 : 12)) return CutOff("its bit masks");
  b.red.bits = b.U32(kMasks);
  b.green.bits = b.U32(kMasks + 4);
  b.blue.bits = b.U32(kMasks + 8);
  if (with_alpha) b.alpha.bits = b.U32(kMasks + 12);
  if (header_size == 40) b.palette_at += with_alpha ? 16 : 12;
  return {};
}

bool IsKnown(unsigned depth, std::uint32_t compression) {
  switch (compression) {
    case kPlain:
      return depth == 1 || depth == 4 || depth == 8 || depth == 16 || depth == 24 ||
             depth == 32;
    case kRle8:
      return depth == 8;
    case kRle4:
      return depth == 4;
    case kBitFields:
    case kAlphaBitFields:
      return depth == 16 || depth == 32;
    default:
      return false;
  }
}

Result<Bitmap> ReadHeader(std::string_view bytes, const ImageLimits& limits) {
  Bitmap b;
  b.bytes = bytes;
  if (!b.Has(0, kFileHeader + 12)) return CutOff("its header");
  b.pixels_at = b.U32(10);
  const std::uint32_t header_size = b.U32(kFileHeader);
  const bool old = header_size == 12;
  if ((!old && header_size < 40) || !b.Has(kFileHeader, header_size)) {
    return Fail(ErrorCode::kUnreadable,
                "the BMP's header has an invalid size; save the picture again",
                std::to_string(header_size));
  }
  const std::size_t at = kFileHeader + 4;
  const auto side = [&](std::size_t place) -> std::int64_t {
    return static_cast<std::int32_t>(b.U32(place));
  };
  b.width = old ? std::int64_t{b.U16(at)} : side(at);
  const std::int64_t height = old ? std::int64_t{b.U16(at + 2)} : side(at + 4);
  b.top_down = height < 0;
  b.height = std::abs(height);
  INTAGLIO_TRY(CheckSize(b.width, b.height, limits));
  b.depth = b.U16(old ? at + 6 : at + 10);
  if (!old) b.compression = b.U32(at + 12);
  if (!IsKnown(b.depth, b.compression)) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("a BMP of {} bits a pixel and compression {} is not "
                            "supported: save it with 24 bits, not compressed, or as PNG",
                            b.depth, b.compression));
  }
  b.palette_at = kFileHeader + header_size;
  b.palette_step = old ? 3 : 4;
  INTAGLIO_TRY(ReadMasks(b, header_size));
  if (b.depth <= 8) {
    const std::uint32_t used = old ? 0 : b.U32(kFileHeader + 32);
    b.palette_count = used == 0 ? std::size_t{1} << b.depth
                                : std::min<std::size_t>(used, std::size_t{1} << b.depth);
    if (!b.Has(b.palette_at, b.palette_count * b.palette_step)) {
      return CutOff("its palette");
    }
  }
  return b;
}

/// Brightness of every index; those past the palette are black.
std::vector<std::uint16_t> ReadPalette(const Bitmap& b, const Luminance& luminance) {
  std::vector<std::uint16_t> grey(256, luminance.Of(0, 0, 0));
  for (std::size_t i = 0; i < b.palette_count; ++i) {
    const std::size_t at = b.palette_at + i * b.palette_step;
    grey[i] = luminance.Of(b.U8(at + 2), b.U8(at + 1), b.U8(at));
  }
  return grey;
}

void ReadRow(const Bitmap& b, std::size_t at, const Luminance& luminance,
             const std::vector<std::uint16_t>& palette, std::uint16_t* row) {
  for (std::int64_t x = 0; x < b.width; ++x) {
    const auto i = static_cast<std::size_t>(x);
    if (b.depth <= 8) {
      const std::size_t bit = i * b.depth;
      const unsigned byte = b.U8(at + bit / 8);
      const unsigned shift = 8 - b.depth - static_cast<unsigned>(bit % 8);
      row[i] = palette[byte >> shift & ((1U << b.depth) - 1)];
    } else if (b.depth == 24) {
      const std::size_t p = at + 3 * i;
      row[i] = luminance.Of(b.U8(p + 2), b.U8(p + 1), b.U8(p));
    } else {
      const std::uint32_t pixel = b.depth == 16 ? b.U16(at + 2 * i) : b.U32(at + 4 * i);
      row[i] = luminance.Of(b.red.Of(pixel, 0), b.green.Of(pixel, 0), b.blue.Of(pixel, 0),
                            b.alpha.Of(pixel, 255));
    }
  }
}

Result<GreyImage> ReadPlain(const Bitmap& b, const Luminance& luminance) {
  const std::size_t row_bytes =
      (static_cast<std::size_t>(b.width) * b.depth + 31) / 32 * 4;
  if (!b.Has(b.pixels_at, 0) ||
      (b.bytes.size() - b.pixels_at) / row_bytes < static_cast<std::size_t>(b.height)) {
    return CutOff(fmt::format("its {} of {}",
                              Counted(static_cast<std::uint64_t>(b.height), "row"),
                              Counted(row_bytes, "byte")));
  }
  const std::vector<std::uint16_t> palette = ReadPalette(b, luminance);
  GreyImage image{static_cast<int>(b.width), static_cast<int>(b.height), {}};
  for (std::int64_t y = 0; y < b.height; ++y) {
    const auto row = static_cast<std::size_t>(b.top_down ? y : b.height - 1 - y);
    ReadRow(b, b.pixels_at + row * row_bytes, luminance, palette, AddRow(image));
  }
  return image;
}

/// Runs: (count, value); (0, 0) next row; (0, 1) end; (0, 2) and a step right and up;
/// (0, n) n values as they are, filled up to 2 bytes. What no run reaches has index 0.
class Runs {
 public:
  Runs(const Bitmap& b, GreyImage& image, const std::vector<std::uint16_t>& palette)
      : b_(b), image_(image), palette_(palette), at_(b.pixels_at) {}

  Status Read() {
    while (y_ < b_.height) {
      if (!b_.Has(at_, 2)) return CutOff(fmt::format("row {} from below", y_));
      const unsigned count = b_.U8(at_), value = b_.U8(at_ + 1);
      at_ += 2;
      if (count > 0) {
        for (unsigned i = 0; i < count; ++i) Set(Index(value, i));
      } else if (value == 0) {
        x_ = 0;
        ++y_;
      } else if (value == 1) {
        return {};
      } else if (value == 2) {
        if (!b_.Has(at_, 2)) return CutOff(fmt::format("row {} from below", y_));
        x_ += b_.U8(at_);
        y_ += b_.U8(at_ + 1);
        at_ += 2;
      } else {
        const std::size_t size = ((std::size_t{value} * b_.depth + 7) / 8 + 1) / 2 * 2;
        if (!b_.Has(at_, size)) return CutOff(fmt::format("row {} from below", y_));
        for (unsigned i = 0; i < value; ++i) {
          Set(b_.depth == 8 ? b_.U8(at_ + i) : Index(b_.U8(at_ + i / 2), i));
        }
        at_ += size;
      }
    }
    return {};
  }

 private:
  /// A byte has two indices of 4 bits, the upper first.
  unsigned Index(unsigned byte, unsigned i) const {
    if (b_.depth == 8) return byte;
    return i % 2 == 0 ? byte >> 4 : byte & 15U;
  }
  void Set(unsigned index) {
    if (x_ < b_.width) {
      image_.samples[static_cast<std::size_t>((b_.height - 1 - y_) * b_.width + x_)] =
          palette_[index];
    }
    ++x_;
  }

  const Bitmap& b_;
  GreyImage& image_;
  const std::vector<std::uint16_t>& palette_;
  std::size_t at_;
  std::int64_t x_ = 0, y_ = 0;
};

Result<GreyImage> ReadRuns(const Bitmap& b, const Luminance& luminance) {
  if (b.top_down) {
    return Fail(ErrorCode::kUnreadable, "a compressed BMP cannot be stored top-down");
  }
  const std::vector<std::uint16_t> palette = ReadPalette(b, luminance);
  GreyImage image{static_cast<int>(b.width), static_cast<int>(b.height), {}};
  image.samples.assign(static_cast<std::size_t>(b.width * b.height), palette[0]);
  INTAGLIO_TRY(Runs(b, image, palette).Read());
  return image;
}

}  // namespace

Result<GreyImage> ParseBmp(std::string_view bytes, const ImageOptions& options) {
  const auto bitmap = INTAGLIO_TRY(ReadHeader(bytes, options.limits));
  const Luminance luminance(options, false);
  const bool runs = bitmap.compression == kRle8 || bitmap.compression == kRle4;
  return runs ? ReadRuns(bitmap, luminance) : ReadPlain(bitmap, luminance);
}

}  // namespace intaglio::image
