#include "engrave/formats/mark_record.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/crc32.h"
#include "engrave/io/whole_file.h"

namespace intaglio::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied as they lie in memory");
constexpr char kMarkMagic[] = "INTMARK1";
constexpr std::uint32_t kMarkVersion = 1;
constexpr std::size_t kMaxMarkFile = std::size_t{1} << 30;

template <typename T>
void PutMarkNumber(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof value);
}

template <typename T>
T MarkNumber(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

auto InMarkFile(const std::filesystem::path& file) {
  return [&file](Error error) {
    error.message = file.string() + ": " + error.message;
    return error;
  };
}

}  // namespace

std::vector<std::byte> EncodeMarkHeader(const MarkRecordHeader& header) {
  std::vector<std::byte> bytes(kMarkHeaderSize);
  std::memcpy(bytes.data(), kMarkMagic, 8);
  PutMarkNumber(bytes.data() + 8, kMarkVersion);
  PutMarkNumber(bytes.data() + 12, static_cast<std::uint32_t>(kMarkRecordSize));
  PutMarkNumber(bytes.data() + 16, header.field_mm);
  PutMarkNumber(bytes.data() + 24, header.power_up);
  PutMarkNumber(bytes.data() + 28, io::Crc32(std::span(bytes).first(28)));
  return bytes;
}

void AppendBurntTick(const BurntTick& tick, std::vector<std::byte>& out) {
  const std::size_t begin = out.size();
  out.resize(begin + kMarkRecordSize);
  std::byte* at = out.data() + begin;
  PutMarkNumber(at, tick.tick);
  for (int axis = 0; axis < 2; ++axis) {
    PutMarkNumber(at + 8 + 8 * axis, tick.place_mm[axis]);
    PutMarkNumber(at + 24 + 4 * axis, static_cast<float>(tick.way_mm[axis]));
  }
  PutMarkNumber(at + 32, static_cast<float>(tick.energy_mj));
  PutMarkNumber(at + 36, tick.run);
  PutMarkNumber(at + 40, tick.mark);
  PutMarkNumber(at + 44, io::Crc32({at, 44}));
}

Result<MarkRecord> ParseMarkRecord(std::span<const std::byte> bytes) {
  if (bytes.size() < kMarkHeaderSize || std::memcmp(bytes.data(), kMarkMagic, 8) != 0 ||
      MarkNumber<std::uint32_t>(bytes.data() + 28) !=
          io::Crc32(std::span(bytes).first(28))) {
    return Fail(ErrorCode::kUnreadable,
                "not a mark record: its header is missing or damaged");
  }
  if (const auto version = MarkNumber<std::uint32_t>(bytes.data() + 8);
      version != kMarkVersion) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the mark record has version {}; this program reads {}",
                            version, kMarkVersion),
                fmt::format("{}", version));
  }
  MarkRecord record;
  record.header.field_mm = MarkNumber<double>(bytes.data() + 16);
  record.header.power_up = MarkNumber<std::uint32_t>(bytes.data() + 24);
  std::size_t offset = kMarkHeaderSize;
  record.ticks.reserve((bytes.size() - offset) / kMarkRecordSize);
  for (; offset + kMarkRecordSize <= bytes.size(); offset += kMarkRecordSize) {
    const std::byte* at = bytes.data() + offset;
    if (MarkNumber<std::uint32_t>(at + 44) != io::Crc32({at, 44})) break;
    BurntTick tick;
    tick.tick = MarkNumber<std::uint64_t>(at);
    for (int axis = 0; axis < 2; ++axis) {
      tick.place_mm[axis] = MarkNumber<double>(at + 8 + 8 * axis);
      tick.way_mm[axis] = MarkNumber<float>(at + 24 + 4 * axis);
    }
    tick.energy_mj = MarkNumber<float>(at + 32);
    if (!tick.place_mm.allFinite() || !tick.way_mm.allFinite() ||
        !std::isfinite(tick.energy_mj))
      break;
    tick.run = MarkNumber<std::uint32_t>(at + 36);
    tick.mark = MarkNumber<std::uint32_t>(at + 40);
    record.ticks.push_back(tick);
  }
  record.torn_bytes = bytes.size() - offset;
  return record;
}

Result<MarkRecord> ReadMarkRecord(const std::filesystem::path& file) {
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxMarkFile));
  return ParseMarkRecord(std::as_bytes(std::span(text))).map_error(InMarkFile(file));
}

Result<MarkRecordHeader> ReadMarkHeader(const std::filesystem::path& file) {
  std::string bytes(kMarkHeaderSize, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    return Fail(ErrorCode::kIo,
                fmt::format("cannot read {}: see that it is there and that this user may "
                            "read it",
                            file.string()),
                file.string());
  }
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return ParseMarkRecord(std::as_bytes(std::span(bytes)))
      .map([](const MarkRecord& record) { return record.header; })
      .map_error(InMarkFile(file));
}

Status WriteMarkRecord(const std::filesystem::path& file, const MarkRecord& record) {
  auto bytes = EncodeMarkHeader(record.header);
  bytes.reserve(bytes.size() + record.ticks.size() * kMarkRecordSize);
  for (const BurntTick& tick : record.ticks) AppendBurntTick(tick, bytes);
  return io::WriteFileAtomically(file, std::span<const std::byte>(bytes));
}

}  // namespace intaglio::formats
