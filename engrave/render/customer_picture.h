#pragma once

// A picture of the piece for the person who gets it: the points as soft bright dots in a
// block with faint edges, on a dark or a transparent ground, without a figure. Work in
// one plane is seen from where it can be read, all other work in perspective.

#include <filesystem>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

/// What is behind the block: dark, or nothing, so that the picture can lie on another
/// one.
enum class Ground { kDark, kTransparent };

struct CustomerPicture {
  int longer_side_px = 2400;  ///< 400 .. 8000; the other side follows from the block.
  Ground ground = Ground::kDark;
  std::string name = {};  ///< A line below the block; empty: none.
};

inline constexpr int kMinCustomerPicturePx = 400;
inline constexpr int kMaxCustomerPicturePx = 8000;

/// Draws the cracks (frame glass, mm) in the block 0..block_size_mm (each side > 0). On a
/// transparent ground the canvas is black where nothing is; it is written with
/// Opacity::kOfLight. The same input gives the same picture. Takes about two seconds.
Canvas RenderCustomerPicture(const PointList& cracks_mm, const Vec3& block_size_mm,
                             const CustomerPicture& picture);

/// The same as a PNG file; with an alpha channel on a transparent ground. Fails with kIo.
Status WriteCustomerPicture(const std::filesystem::path& file, const PointList& cracks_mm,
                            const Vec3& block_size_mm, const CustomerPicture& picture);

}  // namespace intaglio::render
