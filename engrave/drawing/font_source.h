#pragma once

#include <string>
#include <string_view>

namespace intaglio::drawing {

/// Where a font comes from.
struct FontSource {
  /// A font file, by absolute path or with an extension of a font; else the name of a
  /// family that the system's fonts have, "DejaVu Sans" or "DejaVu Sans:Bold" with its
  /// style.
  std::string name;
  /// The bytes of a font's file, which `name` then only names in errors; they have to
  /// outlive the font. Empty: it is read from there.
  std::string_view bytes = {};
};

}  // namespace intaglio::drawing
