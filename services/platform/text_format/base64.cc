#include "services/platform/text_format/base64.h"

#include <openssl/evp.h>

#include <algorithm>

namespace intaglio {

std::string Base64Of(std::span<const std::byte> bytes) {
  // The library counts in int; a piece of whole groups of three needs no padding.
  constexpr std::size_t kPiece = 3 << 20;
  std::string text;
  text.reserve(4 * ((bytes.size() + 2) / 3) + 1);
  while (!bytes.empty()) {
    const auto piece = bytes.first(std::min(kPiece, bytes.size()));
    const std::size_t begin = text.size();
    text.resize(begin + 4 * ((piece.size() + 2) / 3));
    // It adds a null character behind the text, where the string has its own.
    EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data() + begin),
                    reinterpret_cast<const unsigned char*>(piece.data()),
                    static_cast<int>(piece.size()));
    bytes = bytes.subspan(piece.size());
  }
  return text;
}

}  // namespace intaglio
