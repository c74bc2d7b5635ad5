#pragma once

// Codes in pictures, read by libraries that share nothing with the one that makes them:
// libdmtx and zbar, where they are installed.

#include <optional>
#include <string>

#include "tests/engrave/mark/burnt_picture.h"

namespace intaglio::matrix_code {

/// Whether the library is there.
bool CanReadDataMatrix();
bool CanReadQr();

/// The text of the first code; none when there is none.
std::optional<std::string> ReadDataMatrix(mark::BurntPicture picture);
std::optional<std::string> ReadQr(mark::BurntPicture picture);

}  // namespace intaglio::matrix_code
