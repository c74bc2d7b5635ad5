#include "engrave/formats/glass_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "engrave/io/crc32.h"

namespace intaglio::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied as they lie in memory");
constexpr char kGlassMagic[] = "INTGLAS1";
constexpr std::uint32_t kGlassVersion = 2, kOldestGlassVersion = 1;
constexpr std::uint8_t kCollision = 2;  // byte 41

template <typename T>
void PutAt(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof value);
}

template <typename T>
T GetAt(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

Vec3 PlaceAt(const std::byte* at) {
  return {GetAt<double>(at + 8), GetAt<double>(at + 16), GetAt<double>(at + 24)};
}

GlassCrack CrackAt(const std::byte* at) {
  GlassCrack crack;
  crack.tick = GetAt<std::uint64_t>(at);
  crack.position_mm = PlaceAt(at);
  crack.pulse_energy_mj = GetAt<double>(at + 32);
  const auto place = GetAt<std::uint8_t>(at + 40);
  crack.channel = place % 4;
  crack.station = static_cast<std::uint8_t>(1 + place / 4);
  crack.in_glass = GetAt<std::uint8_t>(at + 41) != 0;
  crack.length_mm = GetAt<std::uint16_t>(at + 42) / 1000.0;
  return crack;
}

GlassCollision CollisionAt(const std::byte* at) {
  return {GetAt<std::uint64_t>(at), PlaceAt(at), GetAt<double>(at + 32),
          GetAt<std::uint8_t>(at + 42), GetAt<std::uint8_t>(at + 43)};
}

}  // namespace

std::vector<std::byte> EncodeGlassHeader(const GlassHeader& header) {
  std::vector<std::byte> bytes(kGlassHeaderSize);
  std::memcpy(bytes.data(), kGlassMagic, 8);
  PutAt(bytes.data() + 8, kGlassVersion);
  PutAt(bytes.data() + 12, static_cast<std::uint32_t>(kGlassRecordSize));
  for (int axis = 0; axis < 3; ++axis) {
    PutAt(bytes.data() + 16 + 8 * axis, header.block_size_mm[axis]);
  }
  PutAt(bytes.data() + 40, header.refractive_index);
  PutAt(bytes.data() + 48, header.numerical_aperture);
  PutAt(bytes.data() + 56, header.power_up);
  PutAt(bytes.data() + 60, io::Crc32(std::span(bytes).first(60)));
  return bytes;
}

void AppendGlassCrack(const GlassCrack& crack, std::vector<std::byte>& out) {
  const std::size_t begin = out.size();
  out.resize(begin + kGlassRecordSize);
  std::byte* at = out.data() + begin;
  PutAt(at, crack.tick);
  for (int axis = 0; axis < 3; ++axis) PutAt(at + 8 + 8 * axis, crack.position_mm[axis]);
  PutAt(at + 32, crack.pulse_energy_mj);
  PutAt(at + 40, static_cast<std::uint8_t>(crack.channel + 4 * (crack.station - 1)));
  PutAt(at + 41, static_cast<std::uint8_t>(crack.in_glass ? 1 : 0));
  const double length_um = std::clamp(std::round(1000 * crack.length_mm), 0.0, 65535.0);
  PutAt(at + 42, static_cast<std::uint16_t>(length_um));
  PutAt(at + 44, io::Crc32({at, 44}));
}

void AppendGlassCollision(const GlassCollision& collision, std::vector<std::byte>& out) {
  const std::size_t begin = out.size();
  out.resize(begin + kGlassRecordSize);
  std::byte* at = out.data() + begin;
  PutAt(at, collision.tick);
  for (int axis = 0; axis < 3; ++axis) PutAt(at + 8 + 8 * axis, collision.focus_mm[axis]);
  PutAt(at + 32, collision.overlap_mm);
  PutAt(at + 41, kCollision);
  PutAt(at + 42, collision.body);
  PutAt(at + 43, collision.solid);
  PutAt(at + 44, io::Crc32({at, 44}));
}

Result<GlassRecord> ParseGlassRecord(std::span<const std::byte> bytes) {
  if (bytes.size() < kGlassHeaderSize || std::memcmp(bytes.data(), kGlassMagic, 8) != 0 ||
      GetAt<std::uint32_t>(bytes.data() + 60) != io::Crc32(std::span(bytes).first(60))) {
    return Fail(ErrorCode::kUnreadable,
                "not a glass record: its header is missing or damaged");
  }
  if (const auto version = GetAt<std::uint32_t>(bytes.data() + 8);
      version < kOldestGlassVersion || version > kGlassVersion) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("the glass record has version {}; this program reads {} to {}",
                    version, kOldestGlassVersion, kGlassVersion),
        fmt::format("{}", version));
  }
  GlassRecord record;
  for (int axis = 0; axis < 3; ++axis) {
    record.header.block_size_mm[axis] = GetAt<double>(bytes.data() + 16 + 8 * axis);
  }
  record.header.refractive_index = GetAt<double>(bytes.data() + 40);
  record.header.numerical_aperture = GetAt<double>(bytes.data() + 48);
  record.header.power_up = GetAt<std::uint32_t>(bytes.data() + 56);
  std::size_t offset = kGlassHeaderSize;
  record.cracks.reserve((bytes.size() - offset) / kGlassRecordSize);
  for (; offset + kGlassRecordSize <= bytes.size(); offset += kGlassRecordSize) {
    const std::byte* at = bytes.data() + offset;
    if (GetAt<std::uint32_t>(at + 44) != io::Crc32({at, 44})) break;
    if (GetAt<std::uint8_t>(at + 41) == kCollision) {
      record.collisions.push_back(CollisionAt(at));
    } else {
      record.cracks.push_back(CrackAt(at));
    }
  }
  record.torn_bytes = bytes.size() - offset;
  return record;
}

namespace {

/// At most the first `max_bytes`.
Result<GlassRecord> ReadBeginning(const std::filesystem::path& file,
                                  std::size_t max_bytes) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("cannot open the glass record {}", file.string()),
                file.string());
  }
  std::vector<std::byte> bytes(std::min(static_cast<std::size_t>(in.tellg()), max_bytes));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()),
          static_cast<std::streamsize>(bytes.size()));
  if (!in) {
    return Fail(ErrorCode::kIo,
                fmt::format("cannot read the glass record {}", file.string()),
                file.string());
  }
  return ParseGlassRecord(bytes).map_error([&](Error error) {
    error.message = file.string() + ": " + error.message;
    return error;
  });
}

}  // namespace

Result<GlassRecord> ReadGlassRecord(const std::filesystem::path& file) {
  return ReadBeginning(file, std::numeric_limits<std::size_t>::max());
}

Result<GlassHeader> ReadGlassHeader(const std::filesystem::path& file) {
  return ReadBeginning(file, kGlassHeaderSize).map([](const GlassRecord& record) {
    return record.header;
  });
}

}  // namespace intaglio::formats
