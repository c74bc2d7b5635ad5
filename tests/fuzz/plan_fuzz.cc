// Any bytes as the plan of a job: what is read piece by piece is what is read at once,
// and a packed plan has each place of the order once, in the cell of its point.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/formats/ply_points.h"
#include "engrave/formats/point_file.h"
#include "services/console/plan_packer.h"

namespace {

using namespace intaglio;

/// A file in memory alone.
class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* bytes, std::size_t size)
      : descriptor_(memfd_create("plan", MFD_CLOEXEC)) {
    Require(descriptor_ >= 0, "no file in memory");
    Require(write(descriptor_, bytes, size) == static_cast<ssize_t>(size), "not written");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(descriptor_); }
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

/// All points; an error has a sentence with the file.
Result<PointList> ReadAll(formats::PlyPoints& points) {
  PointList all;
  points.Rewind();
  while (true) {
    auto piece = points.Next();
    if (!piece) return tl::unexpected(piece.error());
    if (piece->empty()) return all;
    Require(piece->size() <= formats::PlyPoints::kPieceCount, "a piece is too long");
    all.insert(all.end(), piece->begin(), piece->end());
  }
}

std::uint32_t NumberAt(const std::string& bytes, std::size_t offset) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

void CheckPacked(const std::string& packed, std::size_t count) {
  Require(packed.size() == console::PackedPlanBytes(count), "another size");
  std::vector<bool> seen(count, false);
  for (std::uint32_t cell = 0; cell < console::kPlanCells; ++cell) {
    const std::uint32_t first = NumberAt(packed, 24 + 4 * std::size_t{cell});
    const std::uint32_t last = NumberAt(packed, 28 + 4 * std::size_t{cell});
    Require(first <= last && last <= count, "a cell outside the plan");
    for (std::size_t at = first; at < last; ++at) {
      std::uint16_t point[4];
      std::memcpy(point, packed.data() + console::kPlanHeaderBytes + 8 * at,
                  sizeof point);
      Require(point[0] / 8192u * 64 + point[1] / 8192u * 8 + point[2] / 8192u == cell,
              "a point in another cell");
      const std::uint32_t place =
          NumberAt(packed, console::kPlanHeaderBytes + 8 * count + 4 * at);
      Require(place < count && !seen[place], "a place twice");
      seen[place] = true;
    }
  }
  Require(NumberAt(packed, 24) == 0 &&
              NumberAt(packed, 24 + 4 * std::size_t{console::kPlanCells}) == count,
          "the cells do not have all points");
}

void Pack(const PointList& all, const Vec3& block_mm) {
  auto packer = console::PlanPacker::Begin(all.size(), block_mm);
  Require(packer.has_value(), "few points");
  packer->Count(all);
  Require(packer->Place(all).has_value(), "the same points");
  const auto packed = packer->Finish();
  Require(packed.has_value(), "the same points");
  CheckPacked(*packed, all.size());
}

/// The plan was replaced by another of this length between the two readings.
void PackOther(const PointList& counted, const PointList& placed, std::size_t length) {
  auto packer = console::PlanPacker::Begin(length, Vec3(100, 80, 50));
  if (!packer) return;
  packer->Count(counted);
  if (!packer->Place(placed)) return;
  const auto packed = packer->Finish();
  if (packed) CheckPacked(*packed, length);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const MemoryFile file(bytes, size);
  auto points = formats::PlyPoints::Open(file.path());
  const auto whole = formats::ParsePly({reinterpret_cast<const char*>(bytes), size});
  if (!points) {
    Require(points.error().message.find(file.path()) != std::string::npos, "no file");
    return 0;
  }
  const auto all = ReadAll(*points);
  if (!all) {
    Require(all.error().message.find(file.path()) != std::string::npos, "no file");
    // What is behind the vertices may make the whole unreadable, and nothing else.
    Require(!whole, "read at once and not in pieces");
    return 0;
  }
  Require(all->size() == points->count(), "another count");
  if (whole) Require(whole->points_mm == *all, "other points");
  Pack(*all, Vec3(100, 80, 50));
  Pack(*all, Vec3(0, 1e-9, 1e300));
  PointList reversed(all->rbegin(), all->rend());
  for (Vec3& point_mm : reversed) point_mm *= 0.5;
  PackOther(*all, reversed, all->size());
  if (!reversed.empty()) {
    PackOther(*all, reversed, all->size() - 1);
    reversed.pop_back();
    PackOther(*all, reversed, all->size());
  }
  return 0;
}
