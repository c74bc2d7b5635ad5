#include "engrave/io/zip_archive.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cstring>
#include <limits>
#include <span>

#include "engrave/io/crc32.h"
#include "engrave/io/lower_case.h"

namespace intaglio::io {
namespace {

using namespace std::literals;

constexpr std::size_t kEndSize = 22, kEntrySize = 46, kHeaderSize = 30;
constexpr std::size_t kEnd64Size = 56, kLocatorSize = 20;
constexpr std::uint32_t kIn64 = 0xFFFFFFFF;

/// Little-endian; 0 beyond the end, which the callers exclude.
template <typename T>
T GetAt(std::string_view bytes, std::size_t at) {
  T value = 0;
  if (at <= bytes.size() && bytes.size() - at >= sizeof value)
    std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::string KeyOf(std::string_view name) {
  while (name.starts_with('/')) name.remove_prefix(1);
  std::string key = LowerCase(name);
  for (char& c : key) {
    if (c == '\\') c = '/';
  }
  return key;
}

/// Exactly `size` bytes, or nothing.
std::optional<std::string> Inflate(std::string_view packed, std::uint64_t size) {
  std::string unpacked(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return std::nullopt;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
  std::uint64_t left_in = packed.size(), left_out = size;
  constexpr std::uint64_t kStep = 1 << 30;  // zlib counts in 32 bits
  int state = Z_OK;
  while (state == Z_OK) {
    const auto in = static_cast<uInt>(std::min(left_in, kStep));
    const auto out = static_cast<uInt>(std::min(left_out, kStep));
    stream.avail_in = in;
    stream.avail_out = out;
    state = inflate(&stream, Z_NO_FLUSH);
    left_in -= in - stream.avail_in;
    left_out -= out - stream.avail_out;
    if (state == Z_OK && in == stream.avail_in && out == stream.avail_out) break;
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END || left_out != 0) return std::nullopt;
  return unpacked;
}

}  // namespace

std::optional<ZipArchive> ZipArchive::Open(std::string_view bytes) {
  ZipArchive archive(bytes);
  if (!archive.ReadDirectory()) return std::nullopt;
  return archive;
}

bool ZipArchive::ReadDirectory() {
  const std::size_t end = bytes_.rfind("PK\5\6"sv);
  if (end == std::string_view::npos || bytes_.size() - end < kEndSize) return false;
  std::uint64_t begin = GetAt<std::uint32_t>(bytes_, end + 16);
  std::uint64_t count = GetAt<std::uint16_t>(bytes_, end + 10);
  const bool has_locator =
      end >= kLocatorSize && bytes_.substr(end - kLocatorSize).starts_with("PK\6\7"sv);
  if (has_locator) {
    const auto end64 = GetAt<std::uint64_t>(bytes_, end - kLocatorSize + 8);
    if (end64 > end || end - end64 < kEnd64Size ||
        !bytes_.substr(end64).starts_with("PK\6\6"sv)) {
      return false;
    }
    count = GetAt<std::uint64_t>(bytes_, end64 + 32);
    begin = GetAt<std::uint64_t>(bytes_, end64 + 48);
  }
  if (begin > end) return false;
  std::string_view directory = bytes_.substr(begin, end - begin);
  for (; count > 0; --count) {
    if (directory.size() < kEntrySize || !directory.starts_with("PK\1\2"sv)) return false;
    Entry entry;
    entry.flags = GetAt<std::uint16_t>(directory, 8);
    entry.method = GetAt<std::uint16_t>(directory, 10);
    entry.crc = GetAt<std::uint32_t>(directory, 16);
    entry.packed_size = GetAt<std::uint32_t>(directory, 20);
    entry.size = GetAt<std::uint32_t>(directory, 24);
    entry.header = GetAt<std::uint32_t>(directory, 42);
    const std::size_t name = GetAt<std::uint16_t>(directory, 28);
    const std::size_t extra = GetAt<std::uint16_t>(directory, 30);
    const std::size_t size =
        kEntrySize + name + extra + GetAt<std::uint16_t>(directory, 32);
    if (directory.size() < size) return false;
    if (!TakeZip64(directory.substr(kEntrySize + name, extra), entry)) return false;
    if (entry.size > std::numeric_limits<std::uint64_t>::max() - unpacked_size_)
      return false;
    unpacked_size_ += entry.size;
    entries_.try_emplace(KeyOf(directory.substr(kEntrySize, name)), entry);
    directory.remove_prefix(size);
  }
  return true;
}

/// Those of the three numbers that have no room in the entry, in this order.
bool ZipArchive::TakeZip64(std::string_view extra, Entry& entry) {
  while (extra.size() >= 4) {
    const auto id = GetAt<std::uint16_t>(extra, 0);
    const std::size_t size = GetAt<std::uint16_t>(extra, 2);
    if (extra.size() - 4 < size) return true;  // padding of some writers
    std::string_view field = extra.substr(4, size);
    extra.remove_prefix(4 + size);
    if (id != 1) continue;
    for (std::uint64_t* number : {&entry.size, &entry.packed_size, &entry.header}) {
      if (*number != kIn64) continue;
      if (field.size() < sizeof *number) return false;
      *number = GetAt<std::uint64_t>(field, 0);
      field.remove_prefix(sizeof *number);
    }
  }
  return true;
}

std::vector<ZipArchive::File> ZipArchive::Files() const {
  std::vector<File> files;
  files.reserve(entries_.size());
  for (const auto& [name, entry] : entries_) files.push_back({name, entry.size});
  return files;
}

bool ZipArchive::Contains(std::string_view name) const {
  return entries_.contains(KeyOf(name));
}

Result<std::string> ZipArchive::Read(std::string_view name) const {
  const auto found = entries_.find(KeyOf(name));
  if (found == entries_.end()) {
    return Fail(ErrorCode::kNotFound, fmt::format("the archive has no {:.80}", name));
  }
  const Entry& entry = found->second;
  constexpr std::uint16_t kStored = 0, kDeflated = 8;
  if ((entry.flags & 1) != 0 || (entry.method != kStored && entry.method != kDeflated)) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("{:.80} is encrypted or packed by method {}", name, entry.method));
  }
  const auto wrong = [&] {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{:.80} is not what the archive says of it", name));
  };
  const std::uint64_t rest = bytes_.size() - std::min(entry.header, bytes_.size());
  if (rest < kHeaderSize || !bytes_.substr(entry.header).starts_with("PK\3\4"sv))
    return wrong();
  const std::uint64_t skip = kHeaderSize +
                             GetAt<std::uint16_t>(bytes_, entry.header + 26) +
                             GetAt<std::uint16_t>(bytes_, entry.header + 28);
  if (rest < skip || rest - skip < entry.packed_size) return wrong();
  const std::string_view packed = bytes_.substr(entry.header + skip, entry.packed_size);
  std::optional<std::string> content;
  if (entry.method == kDeflated) {
    content = Inflate(packed, entry.size);
  } else if (entry.size == entry.packed_size) {
    content = std::string(packed);
  }
  if (!content || Crc32(std::as_bytes(std::span(*content))) != entry.crc) return wrong();
  return std::move(*content);
}

}  // namespace intaglio::io
