#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/image/decoders.h"
#include "engrave/image/luminance.h"

// PCX (ZSoft Technical Reference Manual, revision 5, 1991): a header of 128 bytes, rows
// from the top down, each of its planes one behind the other, packed as runs: a byte of
// 0xC0 and more is a count in its six lower bits, the next byte its value. A palette of
// 256 colours is at the end of the file behind a byte 12. Numbers are little-endian.

namespace intaglio::image {
namespace {

constexpr std::size_t kHeaderSize = 128, kPaletteAt = 16, kLargePalette = 768;
constexpr unsigned kPaletteMark = 12, kGreyPalette = 2;

using PcxColour = std::array<std::uint8_t, 3>;

struct PcxPicture {
  std::string_view bytes;
  std::size_t at = kHeaderSize;
  bool packed = true;
  unsigned depth = 0, planes = 0;
  std::int64_t width = 0, height = 0;
  std::size_t plane_bytes = 0;
  std::vector<PcxColour> palette;  // empty: the planes are red, green and blue
  unsigned run_left = 0, run_value = 0;

  unsigned U8(std::size_t place) const { return static_cast<std::uint8_t>(bytes[place]); }
  unsigned U16(std::size_t place) const { return U8(place) | U8(place + 1) << 8; }

  /// The next byte of the rows; a run may reach over their ends. False: the file ends.
  bool Next(std::uint8_t& value) {
    while (run_left == 0) {
      if (at >= bytes.size()) return false;
      run_value = U8(at++);
      run_left = 1;
      if (packed && run_value >= 0xC0) {
        run_left = run_value & 0x3FU;
        if (at >= bytes.size()) return false;
        run_value = U8(at++);
      }
    }
    --run_left;
    value = static_cast<std::uint8_t>(run_value);
    return true;
  }
};

std::vector<PcxColour> ColoursAt(std::string_view bytes, std::size_t at,
                                 std::size_t count) {
  std::vector<PcxColour> colours(count);
  for (std::size_t i = 0; i < 3 * count; ++i) {
    colours[i / 3][i % 3] = static_cast<std::uint8_t>(bytes[at + i]);
  }
  return colours;
}

/// Grey from black to white.
std::vector<PcxColour> GreysOf(std::size_t count) {
  std::vector<PcxColour> greys(count);
  for (std::size_t i = 0; i < count; ++i) {
    greys[i].fill(static_cast<std::uint8_t>(255 * i / (count - 1)));
  }
  return greys;
}

Status FindPalette(PcxPicture& picture) {
  const unsigned bits = picture.depth * picture.planes;
  if (picture.depth == 8 && picture.planes == 3) return {};
  if (bits == 1) {
    picture.palette = GreysOf(2);
  } else if (bits <= 4 && (picture.depth == 1 || picture.planes == 1)) {
    picture.palette = ColoursAt(picture.bytes, kPaletteAt, std::size_t{1} << bits);
  } else if (bits == 8 && picture.planes == 1) {
    const std::size_t size = picture.bytes.size();
    const bool has_palette = size >= kHeaderSize + kLargePalette + 1 &&
                             picture.U8(size - kLargePalette - 1) == kPaletteMark;
    picture.palette = has_palette && picture.U16(68) != kGreyPalette
                          ? ColoursAt(picture.bytes, size - kLargePalette, 256)
                          : GreysOf(256);
  } else {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the PCX has {} of {}: save it with 1, 4, 8 or 24 "
                            "bits a pixel",
                            Counted(static_cast<std::uint64_t>(picture.planes), "plane"),
                            Counted(static_cast<std::uint64_t>(picture.depth), "bit")));
  }
  return {};
}

Result<PcxPicture> ReadPcxHeader(std::string_view bytes) {
  if (bytes.size() < kHeaderSize) {
    return Fail(ErrorCode::kUnreadable,
                "the PCX ends within its header: copy it again or save it again");
  }
  PcxPicture picture;
  picture.bytes = bytes;
  picture.packed = picture.U8(2) != 0;
  picture.depth = picture.U8(3);
  picture.planes = picture.U8(65);
  picture.plane_bytes = picture.U16(66);
  picture.width = std::int64_t{picture.U16(8)} - picture.U16(4) + 1;
  picture.height = std::int64_t{picture.U16(10)} - picture.U16(6) + 1;
  INTAGLIO_TRY(FindPalette(picture));
  return picture;
}

/// The index of a pixel of a row whose planes are one behind the other.
unsigned IndexAt(const PcxPicture& picture, const std::vector<std::uint8_t>& row,
                 std::size_t x) {
  const std::size_t bit = x * picture.depth;
  const unsigned shift = 8 - picture.depth - static_cast<unsigned>(bit % 8);
  const unsigned mask = (1U << picture.depth) - 1;
  unsigned index = 0;
  for (unsigned plane = 0; plane < picture.planes; ++plane) {
    const unsigned value = row[plane * picture.plane_bytes + bit / 8];
    index |= (value >> shift & mask) << (plane * picture.depth);
  }
  return index;
}

void AppendPcxRow(const PcxPicture& picture, const std::vector<std::uint8_t>& row,
                  const Luminance& luminance, GreyImage& image) {
  std::uint16_t* sample = AddRow(image);
  for (std::size_t x = 0; x < static_cast<std::size_t>(picture.width); ++x) {
    if (picture.palette.empty()) {
      const std::size_t step = picture.plane_bytes;
      *sample++ = luminance.Of(row[x], row[step + x], row[2 * step + x]);
    } else {
      const PcxColour& colour = picture.palette[IndexAt(picture, row, x)];
      *sample++ = luminance.Of(colour[0], colour[1], colour[2]);
    }
  }
}

}  // namespace

bool IsPcx(std::string_view bytes) {
  if (bytes.size() < 4 || bytes[0] != '\x0a') return false;
  const std::string_view versions("\0\2\3\4\5", 5), depths("\1\2\4\10", 4);
  return versions.find(bytes[1]) != versions.npos && (bytes[2] == 0 || bytes[2] == 1) &&
         depths.find(bytes[3]) != depths.npos;
}

Result<GreyImage> ParsePcx(std::string_view bytes, const ImageOptions& options) {
  auto picture = INTAGLIO_TRY(ReadPcxHeader(bytes));
  INTAGLIO_TRY(CheckSize(picture.width, picture.height, options.limits));
  if (8 * picture.plane_bytes < static_cast<std::size_t>(picture.width) * picture.depth) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("the PCX has rows of {} for {} of {}: save "
                            "it again",
                            Counted(picture.plane_bytes, "byte"),
                            Counted(static_cast<std::uint64_t>(picture.width), "pixel"),
                            Counted(static_cast<std::uint64_t>(picture.depth), "bit")));
  }
  const Luminance luminance(options, false);
  GreyImage image{static_cast<int>(picture.width), static_cast<int>(picture.height), {}};
  std::vector<std::uint8_t> row(picture.planes * picture.plane_bytes);
  for (std::int64_t y = 0; y < picture.height; ++y) {
    for (std::uint8_t& value : row) {
      if (picture.Next(value)) continue;
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("the PCX ends in row {} of {}: copy it again or save it "
                              "again",
                              y, picture.height));
    }
    AppendPcxRow(picture, row, luminance, image);
  }
  return image;
}

}  // namespace intaglio::image
