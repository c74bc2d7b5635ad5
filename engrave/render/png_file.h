#pragma once

// A canvas as a PNG file, 8 bits per channel, sRGB; with an alpha channel on request.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

/// kFull: without an alpha channel. kOfLight: black is transparent, and the brighter a
/// pixel is, the less. On black the picture is the canvas; on white what is not bright
/// appears as a tint.
enum class Opacity { kFull, kOfLight };

/// The file's bytes; the same canvas gives the same bytes.
std::vector<std::uint8_t> EncodePng(const Canvas& canvas,
                                    Opacity opacity = Opacity::kFull);

/// Writes the file whole or not at all. Fails with kIo.
Status WritePng(const std::filesystem::path& path, const Canvas& canvas,
                Opacity opacity = Opacity::kFull);

}  // namespace intaglio::render
