#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/image/decoders.h"
#include "engrave/image/exif.h"
#include "engrave/image/icc_light.h"
#include "engrave/image/luminance.h"

// libpng reports an error by a longjmp to the place of setjmp. So the functions that call
// it own nothing with a destructor; such objects are in PngReader, in the stack frame
// above.

namespace intaglio::image {
namespace {

struct PngReader {
  std::string_view bytes;
  std::size_t at = 0;
  char message[160] = "";
  png_structp png = nullptr;
  png_infop info = nullptr;
  png_uint_32 width = 0, height = 0, y = 0;
  int depth = 0, channels = 0, passes = 1;
  double gamma = 0;             // 0: the curve of sRGB
  png_bytep profile = nullptr;  // embedded; of libpng
  png_uint_32 profile_size = 0;
  bool profile_refused = false;  // by libpng, for `message`
  std::vector<png_byte> pixels;  // one row, or all of an interlaced picture

  explicit PngReader(std::string_view file) : bytes(file) {}
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

extern "C" {
static void OnPngError(png_structp png, png_const_charp text) {
  auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
  std::strncpy(reader->message, text, sizeof(reader->message) - 1);
  png_longjmp(png, 1);
}
/// libpng only warns of a profile that it refuses.
static void OnPngWarning(png_structp png, png_const_charp text) {
  auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
  if (std::strncmp(text, "iCCP", 4) != 0) return;
  reader->profile_refused = true;
  std::strncpy(reader->message, text, sizeof(reader->message) - 1);
}

static void ReadPngBytes(png_structp png, png_bytep to, std::size_t count) {
  auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
  if (reader->bytes.size() - reader->at < count) png_error(png, "the file is truncated");
  std::memcpy(to, reader->bytes.data() + reader->at, count);
  reader->at += count;
}
}

/// All kinds become grey, grey with alpha, RGB or RGBA of 8 or 16 bits.
bool ReadHeader(PngReader& r, const ImageLimits& limits) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  png_set_user_limits(r.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_set_chunk_malloc_max(r.png, limits.max_decoder_bytes);
  png_set_read_fn(r.png, &r, ReadPngBytes);
  png_read_info(r.png, r.info);
  png_set_expand(r.png);
  if constexpr (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) png_set_swap(r.png);
  r.passes = png_set_interlace_handling(r.png);
  int srgb = 0;
  double file_gamma = 0;
  if (!png_get_sRGB(r.png, r.info, &srgb) && png_get_gAMA(r.png, r.info, &file_gamma) &&
      file_gamma > 0.1 && file_gamma < 10) {
    constexpr double kSrgbGamma = 0.45455;  // as an approximation of the sRGB curve
    if (std::abs(file_gamma - kSrgbGamma) > 0.005) r.gamma = 1 / file_gamma;
  }
  png_charp name = nullptr;
  int compression = 0;
  png_get_iCCP(r.png, r.info, &name, &compression, &r.profile, &r.profile_size);
  png_read_update_info(r.png, r.info);
  r.width = png_get_image_width(r.png, r.info);
  r.height = png_get_image_height(r.png, r.info);
  r.depth = png_get_bit_depth(r.png, r.info);
  r.channels = png_get_channels(r.png, r.info);
  return true;
}

/// The next row of the last pass into `to`.
bool ReadRow(PngReader& r, png_bytep to) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  png_read_row(r.png, to, nullptr);
  return true;
}

bool ReadEarlierPasses(PngReader& r, std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  for (int pass = 0; pass + 1 < r.passes; ++pass) {
    for (png_uint_32 y = 0; y < r.height; ++y) {
      png_read_row(r.png, r.pixels.data() + y * row_bytes, nullptr);
    }
  }
  return true;
}

void AppendIccRow(const png_byte* row, const PngReader& r, const IccLight& icc,
                  const Luminance& luminance, GreyImage& image) {
  std::uint16_t* sample = AddRow(image);
  icc.Row(row, r.width, sample);
  if (r.channels % 2 != 0) return;
  const auto channels = static_cast<std::size_t>(r.channels);
  for (std::size_t x = 0; x < r.width; ++x) {
    const std::size_t alpha_at = channels * x + channels - 1;
    std::uint16_t wide = 0;
    if (r.depth == 16) std::memcpy(&wide, row + 2 * alpha_at, 2);
    const unsigned alpha = r.depth == 16 ? wide : row[alpha_at];
    sample[x] = luminance.Over(sample[x], alpha);
  }
}

/// Null: the picture has no profile, or the values as stored are asked for.
Result<std::optional<IccLight>> ProfileOf(const PngReader& r,
                                          const ImageOptions& options) {
  if (options.samples != Samples::kLinearLight) return std::nullopt;
  if (r.profile == nullptr) {
    if (!r.profile_refused) return std::nullopt;
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("the ICC profile in the PNG is damaged ({}): save the picture "
                    "as sRGB, or without a profile",
                    r.message));
  }
  PixelKind kind;
  kind.colours = r.channels < 3 ? PixelKind::Colours::kGrey : PixelKind::Colours::kRgb;
  kind.alpha = r.channels % 2 == 0;
  kind.wide = r.depth == 16;
  auto light = INTAGLIO_TRY(
      IccLight::Open({reinterpret_cast<const char*>(r.profile), r.profile_size}, kind));
  return std::optional<IccLight>(std::move(light));
}

/// What follows the pixels is read too: a file without its end is damaged.
bool ReadEnd(PngReader& r) {
  if (setjmp(png_jmpbuf(r.png))) return false;
  png_read_end(r.png, r.info);
  return true;
}

/// Reads the chunk eXIf, before or behind the pixels: the body of a JPEG's segment
/// without its signature.
int OrientationIn(const PngReader& r) {
  png_uint_32 size = 0;
  png_bytep exif = nullptr;
  if (png_get_eXIf_1(r.png, r.info, &size, &exif) == 0 || exif == nullptr) return 1;
  std::string body("Exif\0\0", 6);
  body.append(reinterpret_cast<const char*>(exif), size);
  return OrientationOf(body);
}

template <typename Channel>
void AppendRow(const png_byte* row, const PngReader& r, const Luminance& luminance,
               GreyImage& image) {
  std::uint16_t* sample = AddRow(image);
  for (png_uint_32 x = 0; x < r.width; ++x) {
    Channel c[4] = {};
    const std::size_t size = sizeof(Channel) * static_cast<std::size_t>(r.channels);
    std::memcpy(c, row + x * size, size);
    const bool grey = r.channels < 3;
    const unsigned green = grey ? c[0] : c[1], blue = grey ? c[0] : c[2];
    const bool clear = r.channels % 2 == 0;
    const unsigned alpha = r.channels == 2 ? c[1] : c[3];
    *sample++ =
        clear ? luminance.Of(c[0], green, blue, alpha) : luminance.Of(c[0], green, blue);
  }
}

tl::unexpected<Error> Damaged(const PngReader& r) {
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("the PNG is damaged at row {} of {} (byte {}): {}; save it again", r.y,
                  r.height, r.at, r.message));
}

}  // namespace

Result<GreyImage> ParsePng(std::string_view bytes, const ImageOptions& options) {
  PngReader r(bytes);
  r.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &r, OnPngError, OnPngWarning);
  if (r.png) r.info = png_create_info_struct(r.png);
  if (!r.info) return Fail(ErrorCode::kTooLarge, "not enough memory for the PNG reader");
  if (!ReadHeader(r, options.limits)) return Damaged(r);
  INTAGLIO_TRY(CheckSize(r.width, r.height, options.limits));
  const auto icc = INTAGLIO_TRY(ProfileOf(r, options));
  const std::size_t row_bytes = std::size_t{r.width} *
                                static_cast<std::size_t>(r.channels) *
                                static_cast<std::size_t>(r.depth / 8);
  const bool whole = r.passes > 1;
  const std::uint64_t needed = row_bytes * (whole ? r.height : 1);
  INTAGLIO_TRY(CheckDecoder(needed, options.limits, "save it without interlacing"));
  r.pixels.resize(needed);
  if (!ReadEarlierPasses(r, row_bytes)) return Damaged(r);
  const Luminance luminance(options, r.depth == 16, r.gamma);
  GreyImage image{static_cast<int>(r.width), static_cast<int>(r.height), {}};
  for (r.y = 0; r.y < r.height; ++r.y) {
    png_byte* row = r.pixels.data() + (whole ? r.y * row_bytes : 0);
    if (!ReadRow(r, row)) return Damaged(r);
    if (icc) {
      AppendIccRow(row, r, *icc, luminance, image);
    } else if (r.depth == 16) {
      AppendRow<std::uint16_t>(row, r, luminance, image);
    } else {
      AppendRow<std::uint8_t>(row, r, luminance, image);
    }
  }
  if (!ReadEnd(r)) return Damaged(r);
  return Upright(std::move(image), OrientationIn(r));
}

}  // namespace intaglio::image
