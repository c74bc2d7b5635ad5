#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/image/decoders.h"
#include "engrave/image/exif.h"
#include "engrave/image/icc_light.h"
#include "engrave/image/luminance.h"

// TIFF (revision 6.0, 1992) by libtiff, from memory. Grey and RGB of 8 and 16 bits in
// strips are read row by row, with all of their bits; everything else of at most 8 bits
// is turned into colours of 8 bits by libtiff.

namespace intaglio::image {
namespace {

struct TiffReader {
  std::string_view bytes;
  toff_t at = 0;
  char message[1024] = "";  // of the last error; libtiff writes up to 1024 characters
};

extern "C" {
static tmsize_t ReadTiffBytes(thandle_t handle, void* to, tmsize_t count) {
  auto* r = static_cast<TiffReader*>(handle);
  if (r->at >= r->bytes.size() || count <= 0) return 0;
  const auto size =
      std::min<std::uint64_t>(static_cast<std::uint64_t>(count), r->bytes.size() - r->at);
  std::memcpy(to, r->bytes.data() + r->at, size);
  r->at += size;
  return static_cast<tmsize_t>(size);
}

static tmsize_t WriteTiffBytes(thandle_t, void*, tmsize_t) { return 0; }

static toff_t SeekTiff(thandle_t handle, toff_t offset, int from) {
  auto* r = static_cast<TiffReader*>(handle);
  const toff_t base = from == SEEK_CUR ? r->at : from == SEEK_END ? r->bytes.size() : 0;
  return r->at = base + offset;
}

static int CloseTiff(thandle_t) { return 0; }

static toff_t SizeOfTiff(thandle_t handle) {
  return static_cast<TiffReader*>(handle)->bytes.size();
}

/// libtiff reads in place, and never writes into what is mapped. Without the map it
/// refuses tiles without compression whose size is no multiple of 1024 bytes (4.5.0).
static int MapTiff(thandle_t handle, void** base, toff_t* size) {
  const auto* r = static_cast<const TiffReader*>(handle);
  *base = const_cast<char*>(r->bytes.data());
  *size = r->bytes.size();
  return 1;
}

static void UnmapTiff(thandle_t, void*, toff_t) {}

static int OnTiffError(TIFF*, void* reader, const char*, const char* format,
                       va_list values) {
  auto* r = static_cast<TiffReader*>(reader);
  std::vsnprintf(r->message, sizeof(r->message), format, values);
  return 1;  // nothing is printed
}

static int OnTiffWarning(TIFF*, void*, const char*, const char*, va_list) { return 1; }
}

struct CloseHandle {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using Tiff = std::unique_ptr<TIFF, CloseHandle>;

Tiff OpenTiff(TiffReader& reader, const ImageLimits& limits) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(),
                                      static_cast<tmsize_t>(limits.max_decoder_bytes));
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), OnTiffError, &reader);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), OnTiffWarning, nullptr);
  return Tiff(TIFFClientOpenExt("picture", "r", &reader, ReadTiffBytes, WriteTiffBytes,
                                SeekTiff, CloseTiff, SizeOfTiff, MapTiff, UnmapTiff,
                                options.get()));
}

tl::unexpected<Error> Damaged(const TiffReader& reader) {
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("the TIFF is damaged: {}; save it again",
                  *reader.message == '\0' ? "it ends too early" : reader.message));
}

tl::unexpected<Error> NotRead(const std::string& what, const char* remedy) {
  return Fail(ErrorCode::kUnsupported,
              fmt::format("the TIFF has {}, which is not read: {}", what, remedy), what);
}

/// How the pixels of the first page are stored.
struct Page {
  std::uint32_t width = 0, height = 0;
  std::uint16_t bits = 1, channels = 1, photometric = PHOTOMETRIC_MINISBLACK;
  std::uint16_t planar = PLANARCONFIG_CONTIG, format = SAMPLEFORMAT_UINT;
  std::uint16_t orientation = ORIENTATION_TOPLEFT;
  bool alpha = false, premultiplied = false, tiled = false;
  std::string_view profile;

  unsigned colours() const { return photometric == PHOTOMETRIC_RGB ? 3U : 1U; }
  bool is_grey() const {
    return photometric == PHOTOMETRIC_MINISBLACK || photometric == PHOTOMETRIC_MINISWHITE;
  }
  bool has_plain_rows() const {
    return (bits == 8 || bits == 16) && (is_grey() || photometric == PHOTOMETRIC_RGB) &&
           planar == PLANARCONFIG_CONTIG && !tiled &&
           channels == colours() + (alpha ? 1U : 0U);
  }
};

Page PageOf(TIFF* tiff) {
  Page page;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &page.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &page.height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &page.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &page.channels);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &page.planar);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &page.format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &page.orientation);
  if (TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &page.photometric) == 0 &&
      page.channels >= 3) {
    page.photometric = PHOTOMETRIC_RGB;
  }
  std::uint16_t extra_count = 0;
  std::uint16_t* extra = nullptr;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &extra_count, &extra);
  page.alpha = extra_count == 1;
  page.premultiplied = page.alpha && extra[0] != EXTRASAMPLE_UNASSALPHA;
  page.tiled = TIFFIsTiled(tiff) != 0;
  std::uint32_t size = 0;
  void* profile = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &size, &profile) != 0)
    page.profile = {static_cast<const char*>(profile), size};
  return page;
}

/// A second page would be left out without a word; a thumbnail or a mask is none.
Status RequireOnePage(TIFF* tiff) {
  unsigned pages = 1;
  while (TIFFReadDirectory(tiff) != 0) {
    std::uint32_t kind = 0;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SUBFILETYPE, &kind);
    if ((kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0) ++pages;
  }
  TIFFSetDirectory(tiff, 0);
  if (pages == 1) return {};
  return NotRead(Counted(std::uint64_t{pages}, "page"),
                 "save the one that is meant as a file of its own");
}

Status RequireReadable(const Page& page) {
  if (page.format != SAMPLEFORMAT_UINT && page.format != SAMPLEFORMAT_VOID)
    return NotRead("samples that are signed or fractions",
                   "save it with whole numbers of 8 or 16 bits");
  if (page.bits > 8 && !page.has_plain_rows())
    return NotRead(
        fmt::format("{} of {}", Counted(std::uint64_t{page.channels}, "channel"),
                    Counted(std::uint64_t{page.bits}, "bit")),
        "save it as grey or RGB of 8 or 16 bits, in strips");
  if (page.photometric == PHOTOMETRIC_SEPARATED && !page.profile.empty())
    return NotRead("inks with a colour profile", "save it as RGB");
  return {};
}

/// Null: the picture has no profile, or the values as stored are asked for.
Result<std::optional<IccLight>> ProfileOf(const Page& page, const ImageOptions& options) {
  if (options.samples != Samples::kLinearLight || page.profile.empty())
    return std::nullopt;
  PixelKind kind{.colours = PixelKind::Colours::kRgb, .alpha = true, .wide = false};
  if (page.has_plain_rows()) {
    if (page.is_grey()) kind.colours = PixelKind::Colours::kGrey;
    kind.alpha = page.alpha, kind.wide = page.bits == 16;
  }
  auto light = INTAGLIO_TRY(IccLight::Open(page.profile, kind));
  return std::optional<IccLight>(std::move(light));
}

/// A colour of a pixel that was stored multiplied by its alpha.
template <typename Channel>
Channel Divided(Channel value, Channel alpha) {
  constexpr std::uint64_t top = std::numeric_limits<Channel>::max();
  if (alpha == 0) return value;
  return static_cast<Channel>(std::min<std::uint64_t>(top, value * top / alpha));
}

/// Pixels of `channels` samples, the colours first.
struct Pixels {
  unsigned colours, channels;
  bool alpha, premultiplied, inverse;
};

template <typename Channel>
void Straighten(const Pixels& kind, std::size_t width, Channel* row) {
  for (std::size_t x = 0; x < width; ++x, row += kind.channels) {
    for (unsigned k = 0; k < kind.colours; ++k) {
      if (kind.premultiplied) row[k] = Divided(row[k], row[kind.colours]);
      if (kind.inverse) row[k] = static_cast<Channel>(~row[k]);
    }
  }
}

/// `row`: straightened.
template <typename Channel>
void AppendRow(const Pixels& kind, std::size_t width, const Channel* row,
               const Luminance& luminance, const std::optional<IccLight>& icc,
               GreyImage& image) {
  std::uint16_t* sample = AddRow(image);
  if (icc) icc->Row(row, width, sample);
  for (std::size_t x = 0; x < width; ++x, row += kind.channels) {
    const unsigned green = kind.colours == 3 ? row[1] : row[0];
    const unsigned blue = kind.colours == 3 ? row[2] : row[0];
    if (!icc) sample[x] = luminance.Of(row[0], green, blue);
    if (kind.alpha) sample[x] = luminance.Over(sample[x], row[kind.colours]);
  }
}

template <typename Channel>
Result<GreyImage> ReadPlainRows(TIFF* tiff, const TiffReader& reader, const Page& page,
                                const ImageOptions& options,
                                const std::optional<IccLight>& icc) {
  const Pixels kind{page.colours(), page.channels, page.alpha, page.premultiplied,
                    page.photometric == PHOTOMETRIC_MINISWHITE};
  const std::size_t samples = std::size_t{page.width} * page.channels;
  if (static_cast<std::uint64_t>(TIFFScanlineSize64(tiff)) != samples * sizeof(Channel))
    return Damaged(reader);
  INTAGLIO_TRY(
      CheckDecoder(samples * sizeof(Channel), options.limits, "make it less wide"));
  std::vector<Channel> row(samples);
  const Luminance luminance(options, sizeof(Channel) == 2);
  GreyImage image{static_cast<int>(page.width), static_cast<int>(page.height), {}};
  for (std::uint32_t y = 0; y < page.height; ++y) {
    if (TIFFReadScanline(tiff, row.data(), y, 0) != 1) return Damaged(reader);
    Straighten(kind, page.width, row.data());
    AppendRow(kind, page.width, row.data(), luminance, icc, image);
  }
  return image;
}

struct EndRgba {
  void operator()(TIFFRGBAImage* image) const { TIFFRGBAImageEnd(image); }
};

/// Red, green, blue and alpha of all pixels, premultiplied, in the order of the file.
Result<std::vector<std::uint32_t>> RgbaOf(TIFF* tiff, TiffReader& reader,
                                          const Page& page) {
  TIFFRGBAImage rgba;
  if (TIFFRGBAImageOK(tiff, reader.message) == 0 ||
      TIFFRGBAImageBegin(&rgba, tiff, 1, reader.message) == 0) {
    return NotRead(fmt::format("a kind of pixels that libtiff does not turn into colours "
                               "({})",
                               reader.message),
                   "save it as grey or RGB of 8 or 16 bits");
  }
  const std::unique_ptr<TIFFRGBAImage, EndRgba> end(&rgba);
  rgba.req_orientation = rgba.orientation;  // Upright turns the picture, of any format
  std::vector<std::uint32_t> pixels(std::size_t{page.width} * page.height);
  if (TIFFRGBAImageGet(&rgba, pixels.data(), page.width, page.height) == 0)
    return Damaged(reader);
  return pixels;
}

Result<GreyImage> ReadByColours(TIFF* tiff, TiffReader& reader, const Page& page,
                                const ImageOptions& options,
                                const std::optional<IccLight>& icc) {
  INTAGLIO_TRY(CheckDecoder(std::uint64_t{4} * page.width * page.height, options.limits,
                            "save it as grey or RGB of 8 bits, in strips"));
  const auto pixels = INTAGLIO_TRY(RgbaOf(tiff, reader, page));
  const Pixels kind{3, 4, true, true, false};
  const Luminance luminance(options, false);
  GreyImage image{static_cast<int>(page.width), static_cast<int>(page.height), {}};
  std::vector<std::uint8_t> row(std::size_t{4} * page.width);
  for (std::uint32_t y = 0; y < page.height; ++y) {
    for (std::size_t x = 0; x < page.width; ++x) {
      const std::uint32_t pixel = pixels[std::size_t{y} * page.width + x];
      row[4 * x] = static_cast<std::uint8_t>(TIFFGetR(pixel));
      row[4 * x + 1] = static_cast<std::uint8_t>(TIFFGetG(pixel));
      row[4 * x + 2] = static_cast<std::uint8_t>(TIFFGetB(pixel));
      row[4 * x + 3] = static_cast<std::uint8_t>(TIFFGetA(pixel));
    }
    Straighten(kind, page.width, row.data());
    AppendRow(kind, page.width, row.data(), luminance, icc, image);
  }
  return image;
}

}  // namespace

bool IsTiff(std::string_view bytes) {
  const std::string_view start = bytes.substr(0, 4);
  return start == std::string_view("II*\0", 4) || start == std::string_view("MM\0*", 4) ||
         start == std::string_view("II+\0", 4) || start == std::string_view("MM\0+", 4);
}

Result<GreyImage> ParseTiff(std::string_view bytes, const ImageOptions& options) {
  TiffReader reader{.bytes = bytes};
  const Tiff tiff = OpenTiff(reader, options.limits);
  if (!tiff) return Damaged(reader);
  INTAGLIO_TRY(RequireOnePage(tiff.get()));
  const Page page = PageOf(tiff.get());
  INTAGLIO_TRY(CheckSize(page.width, page.height, options.limits));
  INTAGLIO_TRY(RequireReadable(page));
  const auto icc = INTAGLIO_TRY(ProfileOf(page, options));
  auto image = !page.has_plain_rows()
                   ? ReadByColours(tiff.get(), reader, page, options, icc)
               : page.bits == 16
                   ? ReadPlainRows<std::uint16_t>(tiff.get(), reader, page, options, icc)
                   : ReadPlainRows<std::uint8_t>(tiff.get(), reader, page, options, icc);
  if (!image) return image;
  return Upright(std::move(*image), page.orientation);
}

}  // namespace intaglio::image
