#pragma once

// A canvas as a PNG file, 8 bits per channel, sRGB.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

/// The file's bytes; the same canvas gives the same bytes.
std::vector<std::uint8_t> EncodePng(const Canvas& canvas);

/// Writes the file whole or not at all. Fails with kIo.
Status WritePng(const std::filesystem::path& path, const Canvas& canvas);

}  // namespace intaglio::render
