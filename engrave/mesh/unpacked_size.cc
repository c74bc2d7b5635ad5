#include "engrave/mesh/unpacked_size.h"

#include <cstring>

namespace intaglio::mesh {
namespace {

template <typename T>
T GetAt(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace

std::optional<std::uint64_t> UnpackedSize(std::string_view archive) {
  using namespace std::literals;
  constexpr std::size_t kEndSize = 22;
  constexpr std::size_t kEntrySize = 46;
  const std::size_t end = archive.rfind("PK\5\6"sv);
  if (end == std::string_view::npos || archive.size() - end < kEndSize) return {};
  const std::size_t begin = GetAt<std::uint32_t>(archive, end + 16);
  if (begin > end) return {};
  std::string_view directory = archive.substr(begin, end - begin);
  std::uint64_t total = 0;
  for (auto left = GetAt<std::uint16_t>(archive, end + 10); left > 0; --left) {
    if (directory.size() < kEntrySize || !directory.starts_with("PK\1\2"sv)) return {};
    total += GetAt<std::uint32_t>(directory, 24);
    const std::size_t size = kEntrySize + GetAt<std::uint16_t>(directory, 28) +
                             GetAt<std::uint16_t>(directory, 30) +
                             GetAt<std::uint16_t>(directory, 32);
    if (directory.size() < size) return {};
    directory.remove_prefix(size);
  }
  return total;
}

}  // namespace intaglio::mesh
