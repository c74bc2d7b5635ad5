#include "engrave/formats/record_file.h"

#include <fmt/format.h>

#include "engrave/io/crc32.h"

namespace intaglio::formats {
namespace {

constexpr std::size_t kLettersSize = 8, kSealSize = 4;

}  // namespace

void Seal(std::span<std::byte> bytes) {
  const auto end = bytes.size() - kSealSize;
  PutNumber(bytes.data() + end, io::Crc32(bytes.first(end)));
}

bool IsSealed(std::span<const std::byte> bytes) {
  const auto end = bytes.size() - kSealSize;
  return NumberAt<std::uint32_t>(bytes.data() + end) == io::Crc32(bytes.first(end));
}

std::vector<std::byte> NewRecordHeader(const RecordKind& kind) {
  std::vector<std::byte> bytes(kind.header_size);
  std::memcpy(bytes.data(), kind.letters.data(), kLettersSize);
  PutNumber(bytes.data() + 8, kind.version);
  PutNumber(bytes.data() + 12, static_cast<std::uint32_t>(kind.record_size));
  return bytes;
}

std::span<std::byte> AppendRecord(const RecordKind& kind, std::vector<std::byte>& out) {
  out.resize(out.size() + kind.record_size);
  return std::span(out).last(kind.record_size);
}

Status CheckRecordHeader(const RecordKind& kind, std::span<const std::byte> bytes) {
  if (bytes.size() < kind.header_size ||
      std::memcmp(bytes.data(), kind.letters.data(), kLettersSize) != 0 ||
      !IsSealed(bytes.first(kind.header_size))) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("the header of the {} is missing or damaged: name the file "
                            "that the machine wrote",
                            kind.name));
  }
  const auto version = NumberAt<std::uint32_t>(bytes.data() + 8);
  if (version >= kind.oldest_version && version <= kind.version) return {};
  return Fail(ErrorCode::kUnsupported,
              fmt::format("the {} has version {}; this program reads {} to {}", kind.name,
                          version, kind.oldest_version, kind.version),
              fmt::format("{}", version));
}

}  // namespace intaglio::formats
