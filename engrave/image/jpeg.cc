#include <fmt/format.h>
#include <jerror.h>
#include <jpeglib.h>

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "engrave/core/try.h"
#include "engrave/image/decoders.h"
#include "engrave/image/exif.h"
#include "engrave/image/icc_light.h"
#include "engrave/image/luminance.h"

// libjpeg reports an error by a call that must not return: a longjmp to the place of
// setjmp. So the functions that call it own nothing with a destructor; such objects are
// in JpegReader, in the stack frame above.

namespace intaglio::image {
namespace {

// A progressive file may go over all pixels once a scan; encoders write about ten.
constexpr int kMaxScans = 64;

struct JpegReader {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf out;
  char message[JMSG_LENGTH_MAX] = "";
  bool out_of_memory = false;
  std::vector<JSAMPLE> row;
  JOCTET* profile = nullptr;  // embedded; of malloc
  unsigned profile_size = 0;

  JpegReader() = default;
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() {
    jpeg_destroy_decompress(&jpeg);
    std::free(profile);
  }
};

extern "C" {
static void OnJpegError(j_common_ptr jpeg) {
  auto* reader = static_cast<JpegReader*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, reader->message);
  reader->out_of_memory = jpeg->err->msg_code == JERR_NO_BACKING_STORE ||
                          jpeg->err->msg_code == JERR_OUT_OF_MEMORY;
  std::longjmp(reader->out, 1);
}

/// Damage that libjpeg would fill with grey is an error here; bytes between segments are
/// not.
static void OnJpegMessage(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  switch (jpeg->err->msg_code) {
    case JWRN_EXTRANEOUS_DATA:
    case JWRN_JFIF_MAJOR:
    case JWRN_ADOBE_XFORM:
      return;
    default:
      OnJpegError(jpeg);
  }
}

static void OnJpegProgress(j_common_ptr jpeg) {
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number > kMaxScans) {
    auto* reader = static_cast<JpegReader*>(jpeg->client_data);
    std::snprintf(reader->message, sizeof(reader->message), "more than %d scans",
                  kMaxScans);
    std::longjmp(reader->out, 1);
  }
}
}

bool ReadHeader(JpegReader& r, std::string_view bytes) {
  if (setjmp(r.out)) return false;
  jpeg_mem_src(&r.jpeg, reinterpret_cast<const unsigned char*>(bytes.data()),
               static_cast<unsigned long>(bytes.size()));
  jpeg_save_markers(&r.jpeg, JPEG_APP0 + 1, 0xFFFF);
  jpeg_save_markers(&r.jpeg, JPEG_APP0 + 2, 0xFFFF);
  jpeg_read_header(&r.jpeg, TRUE);
  jpeg_read_icc_profile(&r.jpeg, &r.profile, &r.profile_size);
  return true;
}

bool Start(JpegReader& r, const ImageLimits& limits) {
  if (setjmp(r.out)) return false;
  switch (r.jpeg.jpeg_color_space) {
    case JCS_GRAYSCALE:
      r.jpeg.out_color_space = JCS_GRAYSCALE;
      break;
    case JCS_CMYK:
    case JCS_YCCK:
      r.jpeg.out_color_space = JCS_CMYK;
      break;
    default:
      r.jpeg.out_color_space = JCS_RGB;
  }
  r.jpeg.mem->max_memory_to_use = static_cast<long>(limits.max_decoder_bytes);
  jpeg_start_decompress(&r.jpeg);
  return true;
}

bool ReadRow(JpegReader& r) {
  if (setjmp(r.out)) return false;
  JSAMPROW row = r.row.data();
  jpeg_read_scanlines(&r.jpeg, &row, 1);
  return true;
}

bool ReadEnd(JpegReader& r) {
  if (setjmp(r.out)) return false;
  jpeg_finish_decompress(&r.jpeg);
  return true;
}

void AppendRow(const JpegReader& r, const Luminance& luminance, GreyImage& image) {
  std::uint16_t* sample = AddRow(image);
  const JSAMPLE* c = r.row.data();
  const JSAMPLE* const end = c + r.row.size();
  if (r.jpeg.out_color_space == JCS_GRAYSCALE) {
    for (; c != end; ++c) *sample++ = luminance.Of(*c, *c, *c);
  } else if (r.jpeg.out_color_space == JCS_RGB) {
    for (; c != end; c += 3) *sample++ = luminance.Of(c[0], c[1], c[2]);
  } else {
    // Programs that write CMYK store the light that an ink leaves, 255 for no ink, and
    // mark that by Adobe's marker; by the format's specification the value is the ink.
    const unsigned flip = r.jpeg.saw_Adobe_marker ? 0 : 255;
    const auto light = [&](unsigned ink, unsigned black) {
      return ((ink ^ flip) * (black ^ flip) + 127) / 255;
    };
    for (; c != end; c += 4) {
      *sample++ = luminance.Of(light(c[0], c[3]), light(c[1], c[3]), light(c[2], c[3]));
    }
  }
}

/// Null: the picture has no profile, or the values as stored are asked for.
Result<std::optional<IccLight>> ProfileOf(const JpegReader& r,
                                          const ImageOptions& options) {
  if (options.samples != Samples::kLinearLight || r.profile == nullptr) {
    return std::nullopt;
  }
  PixelKind kind;
  if (r.jpeg.out_color_space == JCS_GRAYSCALE) kind.colours = PixelKind::Colours::kGrey;
  if (r.jpeg.out_color_space == JCS_CMYK) {
    kind.colours = r.jpeg.saw_Adobe_marker ? PixelKind::Colours::kInverseCmyk
                                           : PixelKind::Colours::kCmyk;
  }
  auto light = INTAGLIO_TRY(
      IccLight::Open({reinterpret_cast<const char*>(r.profile), r.profile_size}, kind));
  return std::optional<IccLight>(std::move(light));
}

int OrientationIn(const JpegReader& r) {
  for (const jpeg_marker_struct* m = r.jpeg.marker_list; m; m = m->next) {
    const std::string_view body(reinterpret_cast<const char*>(m->data), m->data_length);
    const int orientation = OrientationOf(body);
    if (orientation != 1) return orientation;
  }
  return 1;
}

tl::unexpected<Error> Refused(const JpegReader& r, const ImageLimits& limits) {
  if (r.out_of_memory) {
    return Fail(
        ErrorCode::kTooLarge,
        fmt::format("decoding the JPEG takes more than the {} additional bytes allowed: "
                    "save it without \"progressive\", or raise the limit",
                    limits.max_decoder_bytes));
  }
  return Fail(ErrorCode::kUnreadable,
              fmt::format("the JPEG is damaged at row {} of {}: {}; save it again",
                          r.jpeg.output_scanline, r.jpeg.image_height, r.message));
}

}  // namespace

Result<GreyImage> ParseJpeg(std::string_view bytes, const ImageOptions& options) {
  JpegReader r;
  r.jpeg.err = jpeg_std_error(&r.errors);
  r.errors.error_exit = OnJpegError;
  r.errors.emit_message = OnJpegMessage;
  r.jpeg.client_data = &r;
  // Allocates a few hundred bytes of its own; a failure of that ends in OnJpegError.
  if (setjmp(r.out)) return Refused(r, options.limits);
  jpeg_create_decompress(&r.jpeg);
  r.progress.progress_monitor = OnJpegProgress;
  r.jpeg.progress = &r.progress;
  if (!ReadHeader(r, bytes)) return Refused(r, options.limits);
  INTAGLIO_TRY(CheckSize(r.jpeg.image_width, r.jpeg.image_height, options.limits));
  if (!Start(r, options.limits)) return Refused(r, options.limits);
  r.row.resize(std::size_t{r.jpeg.output_width} *
               static_cast<std::size_t>(r.jpeg.output_components));
  const int orientation = OrientationIn(r);  // libjpeg clears the list of markers at the
                                             // end of the file
  const Luminance luminance(options, false);
  const auto icc = INTAGLIO_TRY(ProfileOf(r, options));
  GreyImage image{
      static_cast<int>(r.jpeg.output_width), static_cast<int>(r.jpeg.output_height), {}};
  while (r.jpeg.output_scanline < r.jpeg.output_height) {
    if (!ReadRow(r)) return Refused(r, options.limits);
    if (icc) {
      icc->Row(r.row.data(), r.jpeg.output_width, AddRow(image));
    } else {
      AppendRow(r, luminance, image);
    }
  }
  if (!ReadEnd(r)) return Refused(r, options.limits);
  return Upright(std::move(image), orientation);
}

}  // namespace intaglio::image
