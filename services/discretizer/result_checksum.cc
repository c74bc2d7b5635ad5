#include "services/discretizer/result_checksum.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <string_view>
#include <vector>

#include "engrave/io/crc32.h"

namespace intaglio::discretizer {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Collects bytes, so that the checksum is computed of large pieces.
class Sum {
 public:
  template <typename Number>
  void Add(Number value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof value);
    if (bytes_.size() >= kPieceBytes) Flush();
  }
  void AddText(std::string_view text) {
    Add(static_cast<std::uint32_t>(text.size()));
    for (const char c : text) Add(c);
  }
  std::uint32_t crc() {
    Flush();
    return crc_;
  }

 private:
  static constexpr std::size_t kPieceBytes = 1 << 16;
  void Flush() {
    crc_ = io::Crc32(bytes_, crc_);
    bytes_.clear();
  }
  std::vector<std::byte> bytes_;
  std::uint32_t crc_ = 0;
};

void Add(const PointCloud& cloud, Sum& sum) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p_mm = cloud.points_mm[i];
    sum.Add(p_mm.x());
    sum.Add(p_mm.y());
    sum.Add(p_mm.z());
    sum.Add(cloud.source[i]);
  }
}

void Add(const mark::Pen& pen, Sum& sum) {
  sum.AddText(pen.name);
  sum.Add(pen.speed_mm_s);
  sum.Add(pen.power_ratio);
  sum.Add(pen.frequency_hz);
  sum.Add(pen.pass_count);
  sum.Add(pen.depth_mm);
  sum.Add(pen.plunge_mm_s);
}

void Add(const mark::Mark& mark, Sum& sum) {
  sum.Add(mark.pen);
  sum.Add(static_cast<std::uint8_t>(mark.closed));
  sum.Add(mark.web_mm);
  sum.Add(static_cast<std::uint32_t>(mark.places.size()));
  for (const mark::Place& place : mark.places) {
    sum.Add(place.at_mm.x());
    sum.Add(place.at_mm.y());
    sum.Add(place.bulge);
  }
  if (!mark::IsRow(mark)) return;
  for (const mark::Place& place : mark.places)
    sum.Add(static_cast<std::uint8_t>(place.dark));
}

}  // namespace

std::string ChecksumOf(const host::StageResult& result) {
  Sum sum;
  Add(result.cloud, sum);
  if (result.marks) {
    sum.Add(static_cast<std::uint32_t>(result.marks->pens.size()));
    for (const mark::Pen& pen : result.marks->pens) Add(pen, sum);
    for (const mark::Mark& mark : result.marks->marks) Add(mark, sum);
  }
  return fmt::format("{}-{:08x}", result.size(), sum.crc());
}

}  // namespace intaglio::discretizer
