#pragma once

// The fonts that this computer has, as found by fontconfig. It is asked once in a
// process: a font that is installed meanwhile is found by the next one.

#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::drawing {

/// A font that can be engraved: it has outlines.
struct InstalledFont {
  std::string family;  ///< "DejaVu Sans"
  std::string style;   ///< "Bold"
  std::string file;
};

/// By family, style and file.
std::vector<InstalledFont> InstalledFonts();

/// Whether it is the name of a file, not of a family: it has a folder, or the extension
/// of a font.
bool IsFontFile(std::string_view font);

/// The file of a font of this family and style ("Family" or "Family:Style"); no
/// substitute for a missing font. kNotFound names families of similar name.
Result<std::string> FindFontFile(std::string_view family);

/// Files of fonts that may have these characters, in the order in which to try them:
/// usual fonts of Debian first, then what fontconfig proposes. At most 16 of each kind.
std::vector<std::string> FallbackFontFiles(std::u32string_view characters);

}  // namespace intaglio::drawing
