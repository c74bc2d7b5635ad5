#pragma once

// The light of pixels whose colours an ICC profile describes (ICC.1:2010), by lcms2.

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::image {

/// How the pixels of a picture are stored.
struct PixelKind {
  enum class Colours { kGrey, kRgb, kCmyk, kInverseCmyk };  ///< inverse: 255 is no ink
  Colours colours = Colours::kRgb;
  bool alpha = false;  ///< one more channel, which is skipped
  bool wide = false;   ///< channels of 16 bits, of this computer's byte order; else of 8
};

/// Not for use by two threads at once.
class IccLight {
 public:
  /// kUnreadable: the profile is damaged, or is of other colours than the pixels; a
  /// profile of RGB is taken for grey pixels, too.
  static Result<IccLight> Open(std::string_view profile, const PixelKind& kind);

  /// Relative luminance of `count` pixels, 0..65535, relative colorimetric with the
  /// profile's white as 65535.
  void Row(const void* pixels, std::size_t count, std::uint16_t* light) const;

 private:
  struct Close {
    void operator()(void* transform) const;
  };
  IccLight() = default;
  void Convert(const void* pixels, std::size_t count, std::uint16_t* light) const;

  std::unique_ptr<void, Close> transform_;
  PixelKind kind_;
  bool grey_by_rgb_ = false;
  mutable std::vector<float> linear_;
  mutable std::vector<std::uint16_t> triples_;
};

}  // namespace intaglio::image
