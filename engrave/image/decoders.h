#pragma once

// The readers behind ParseImage, one a format. Each is given bytes that begin with its
// signature.

#include <string_view>

#include "engrave/image/image_file.h"

namespace intaglio::image {

Result<GreyImage> ParseBmp(std::string_view bytes, const ImageOptions& options);
/// Whether the bytes begin as a PCX does: it has no signature but small numbers.
bool IsPcx(std::string_view bytes);
Result<GreyImage> ParsePcx(std::string_view bytes, const ImageOptions& options);
Result<GreyImage> ParsePng(std::string_view bytes, const ImageOptions& options);
bool IsTiff(std::string_view bytes);
Result<GreyImage> ParseTiff(std::string_view bytes, const ImageOptions& options);
Result<GreyImage> ParseJpeg(std::string_view bytes, const ImageOptions& options);

/// kTooLarge when the picture has more pixels than allowed, kUnreadable when it has none.
Status CheckSize(std::int64_t width, std::int64_t height, const ImageLimits& limits);

/// kTooLarge when the decoder needs more memory than allowed. `remedy` ends the sentence.
Status CheckDecoder(std::uint64_t needed_bytes, const ImageLimits& limits,
                    std::string_view remedy);

/// Another row of samples below the others. The first call reserves the address space of
/// all rows; memory is used only for the rows written, so a header alone uses none.
std::uint16_t* AddRow(GreyImage& image);

}  // namespace intaglio::image
