#pragma once

// Bytes as text (RFC 4648, 4), as pages and data URIs carry them.

#include <cstddef>
#include <span>
#include <string>

namespace intaglio {

std::string Base64Of(std::span<const std::byte> bytes);

}  // namespace intaglio
