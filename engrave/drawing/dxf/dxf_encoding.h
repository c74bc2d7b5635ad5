#pragma once

// The two encodings of a DXF beside UTF-8 text: the code page of files before AutoCAD
// 2007
// ($DWGCODEPAGE), and the binary form (DXF reference, "Binary DXF files").

#include <optional>
#include <string>
#include <string_view>

#include "engrave/core/result.h"

namespace intaglio::drawing {

/// Whether the file begins as a binary DXF.
bool IsBinaryDxf(std::string_view file);

/// The same groups as lines of text. kUnreadable: it ends within a group, or a code has
/// no known type of value; kTooLarge: more than `max_bytes` of text.
Result<std::string> TextOfBinaryDxf(std::string_view file, std::size_t max_bytes);

/// The file with all lines in UTF-8, those that are not so already converted from the
/// code page that it declares ("ANSI_1252"); empty: they are so as they are, or it
/// declares none. Nothing when the code page is not known to the system; `code_page` is
/// its name.
std::optional<std::string> DxfInUtf8(std::string_view file, std::string& code_page);

}  // namespace intaglio::drawing
