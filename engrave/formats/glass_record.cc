#include "engrave/formats/glass_record.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/formats/record_file.h"

namespace intaglio::formats {
namespace {

constexpr RecordKind kGlass{"INTGLAS1", "glass record",   1,
                            2,          kGlassHeaderSize, kGlassRecordSize};
constexpr std::uint64_t kMaxGlassFile = std::uint64_t{1} << 36;
constexpr std::size_t kGlassPieceBytes = 1 << 20;
constexpr std::uint8_t kCollision = 2;  // byte 41

void PutPlace(std::byte* at, const Vec3& place_mm) {
  for (int axis = 0; axis < 3; ++axis) PutNumber(at + 8 + 8 * axis, place_mm[axis]);
}

Vec3 PlaceAt(const std::byte* at) {
  return {NumberAt<double>(at + 8), NumberAt<double>(at + 16), NumberAt<double>(at + 24)};
}

GlassCrack CrackAt(const std::byte* at) {
  GlassCrack crack;
  crack.tick = NumberAt<std::uint64_t>(at);
  crack.position_mm = PlaceAt(at);
  crack.pulse_energy_mj = NumberAt<double>(at + 32);
  const auto place = NumberAt<std::uint8_t>(at + 40);
  crack.channel = place % 4;
  crack.station = static_cast<std::uint8_t>(1 + place / 4);
  crack.in_glass = NumberAt<std::uint8_t>(at + 41) != 0;
  crack.length_mm = NumberAt<std::uint16_t>(at + 42) / 1000.0;
  return crack;
}

GlassCollision CollisionAt(const std::byte* at) {
  return {NumberAt<std::uint64_t>(at), PlaceAt(at), NumberAt<double>(at + 32),
          NumberAt<std::uint8_t>(at + 42), NumberAt<std::uint8_t>(at + 43)};
}

}  // namespace

std::vector<std::byte> EncodeGlassHeader(const GlassHeader& header) {
  std::vector<std::byte> bytes = NewRecordHeader(kGlass);
  for (int axis = 0; axis < 3; ++axis) {
    PutNumber(bytes.data() + 16 + 8 * axis, header.block_size_mm[axis]);
  }
  PutNumber(bytes.data() + 40, header.refractive_index);
  PutNumber(bytes.data() + 48, header.numerical_aperture);
  PutNumber(bytes.data() + 56, header.power_up);
  Seal(bytes);
  return bytes;
}

void AppendGlassCrack(const GlassCrack& crack, std::vector<std::byte>& out) {
  const std::span<std::byte> record = AppendRecord(kGlass, out);
  std::byte* at = record.data();
  PutNumber(at, crack.tick);
  PutPlace(at, crack.position_mm);
  PutNumber(at + 32, crack.pulse_energy_mj);
  PutNumber(at + 40, static_cast<std::uint8_t>(crack.channel + 4 * (crack.station - 1)));
  PutNumber(at + 41, static_cast<std::uint8_t>(crack.in_glass ? 1 : 0));
  const double length_um = std::clamp(std::round(1000 * crack.length_mm), 0.0, 65535.0);
  PutNumber(at + 42, static_cast<std::uint16_t>(length_um));
  Seal(record);
}

void AppendGlassCollision(const GlassCollision& collision, std::vector<std::byte>& out) {
  const std::span<std::byte> record = AppendRecord(kGlass, out);
  std::byte* at = record.data();
  PutNumber(at, collision.tick);
  PutPlace(at, collision.focus_mm);
  PutNumber(at + 32, collision.overlap_mm);
  PutNumber(at + 41, kCollision);
  PutNumber(at + 42, collision.body);
  PutNumber(at + 43, collision.solid);
  Seal(record);
}

namespace {

GlassHeader HeaderAt(const std::byte* at) {
  GlassHeader header;
  for (int axis = 0; axis < 3; ++axis)
    header.block_size_mm[axis] = NumberAt<double>(at + 16 + 8 * axis);
  header.refractive_index = NumberAt<double>(at + 40);
  header.numerical_aperture = NumberAt<double>(at + 48);
  header.power_up = NumberAt<std::uint32_t>(at + 56);
  return header;
}

/// A record from its bytes in pieces, the first with the header.
class GlassReader {
 public:
  explicit GlassReader(const std::function<void(const GlassCrack&)>& take_crack)
      : take_crack_(take_crack) {}

  /// `size`: of all pieces.
  Status Receive(std::span<const std::byte> bytes, std::uint64_t size) {
    if (!has_header_) {
      INTAGLIO_TRY(CheckRecordHeader(kGlass, bytes));
      has_header_ = true;
      record_.header = HeaderAt(bytes.data());
      record_.torn_bytes = size - kGlassHeaderSize;
      if (!take_crack_) record_.cracks.reserve(record_.torn_bytes / kGlassRecordSize);
      bytes = bytes.subspan(kGlassHeaderSize);
    }
    if (is_torn_) return {};
    begun_.insert(begun_.end(), bytes.begin(), bytes.end());
    std::span<const std::byte> rest = begun_;
    for (; rest.size() >= kGlassRecordSize; rest = rest.subspan(kGlassRecordSize)) {
      is_torn_ = !IsSealed(rest.first(kGlassRecordSize));
      if (is_torn_) return {};
      TakeRecord(rest.data());
      record_.torn_bytes -= kGlassRecordSize;
    }
    begun_.erase(begun_.begin(), begun_.end() - static_cast<std::ptrdiff_t>(rest.size()));
    return {};
  }
  GlassRecord Finish() { return std::move(record_); }

 private:
  void TakeRecord(const std::byte* at) {
    if (NumberAt<std::uint8_t>(at + 41) == kCollision) {
      record_.collisions.push_back(CollisionAt(at));
    } else if (take_crack_) {
      take_crack_(CrackAt(at));
    } else {
      record_.cracks.push_back(CrackAt(at));
    }
  }

  const std::function<void(const GlassCrack&)>& take_crack_;
  GlassRecord record_;
  std::vector<std::byte> begun_;  // bytes that are not records yet
  bool has_header_ = false, is_torn_ = false;
};

}  // namespace

Result<GlassRecord> ParseGlassRecord(std::span<const std::byte> bytes) {
  const std::function<void(const GlassCrack&)> keep;
  GlassReader reader(keep);
  INTAGLIO_TRY(reader.Receive(bytes, bytes.size()));
  return reader.Finish();
}

Result<GlassRecord> ReadGlassRecord(
    const std::filesystem::path& file,
    const std::function<void(const GlassCrack&)>& take_crack) {
  GlassReader reader(take_crack);
  INTAGLIO_TRY(
      io::ReadInPieces(file, kMaxGlassFile, kGlassPieceBytes,
                       [&](std::span<const std::byte> piece, std::uint64_t size) {
                         return reader.Receive(piece, size);
                       }));
  return reader.Finish();
}

Result<GlassHeader> ReadGlassHeader(const std::filesystem::path& file) {
  return ReadRecordHeader(kGlass, file, ParseGlassRecord)
      .map([](const GlassRecord& record) { return record.header; });
}

}  // namespace intaglio::formats
