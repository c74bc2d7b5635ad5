#include "services/console/job_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numeric>
#include <random>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "services/client/proof/proof_evidence.h"
#include "services/job/options.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kOutcomeShift = 29;
constexpr std::size_t kMaxRecords = 65536;

template <typename Value>
void Append(std::string& bytes, Value value) {
  char raw[sizeof value];
  std::memcpy(raw, &value,
              sizeof value);  // a little-endian host, as the formats' readers
  bytes.append(raw, sizeof value);
}

std::uint16_t Share(double value, double whole) {
  const double ratio = whole > 0 ? std::clamp(value / whole, 0.0, 1.0) : 0.0;
  return static_cast<std::uint16_t>(std::lround(ratio * 65535));
}

Result<std::string> ReadPart(const fs::path& file, std::uint64_t offset,
                             std::size_t max_bytes) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    return Fail(
        ErrorCode::kNotFound,
        fmt::format("{} is not there: the job has no plan yet, or its folder is on "
                    "another computer",
                    file.string()),
        file.string());
  }
  in.seekg(static_cast<std::streamoff>(offset));
  std::string bytes(max_bytes, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(max_bytes));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return bytes;
}

}  // namespace

Result<std::string> PackPlan(const PointList& path_mm, const Vec3& block_mm) {
  const std::size_t count = path_mm.size();
  if (count >= std::size_t{1} << kOutcomeShift)
    return Fail(ErrorCode::kTooLarge, fmt::format("{} points are too many", count));
  std::vector<std::uint32_t> places(count);
  std::iota(places.begin(), places.end(), 0u);
  std::shuffle(places.begin(), places.end(), std::mt19937(1));
  std::string bytes = "INTPLAN1";
  bytes.reserve(24 + 12 * count);
  Append(bytes, static_cast<std::uint32_t>(count));
  for (int axis = 0; axis < 3; ++axis) Append(bytes, static_cast<float>(block_mm[axis]));
  for (const std::uint32_t place : places) {
    for (int axis = 0; axis < 3; ++axis)
      Append(bytes, Share(path_mm[place][axis], block_mm[axis]));
    Append(bytes, Share(place, static_cast<double>(count)));
  }
  for (const std::uint32_t place : places) Append(bytes, place);
  return bytes;
}

Result<std::string> PackMade(std::span<const std::byte> header,
                             std::span<const std::byte> records, std::uint32_t from) {
  std::vector<std::byte> file(header.begin(), header.end());
  file.insert(file.end(), records.begin(), records.end());
  const auto journal = INTAGLIO_TRY(formats::ParseJournal(file));
  const std::uint64_t whole =
      (records.size() - std::min<std::uint64_t>(journal.torn_bytes, records.size())) /
      formats::kJournalRecordSize;
  std::string bytes;
  Append(bytes, static_cast<std::uint32_t>(from + whole));
  for (const formats::JournalRecord& record : journal.records) {
    if (record.kind != formats::JournalKind::kOutcome || record.point >> kOutcomeShift)
      continue;
    Append(bytes, record.point | static_cast<std::uint32_t>(record.outcome)
                                     << kOutcomeShift);
  }
  return bytes;
}

Result<std::string> ReadPlan(const fs::path& folder) {
  INTAGLIO_TRY(ReadPart(folder / "path.ply", 0, 1));
  const auto job = INTAGLIO_TRY(client::ReadFrozenJob(folder / "job.json"));
  const auto plan = INTAGLIO_TRY(formats::ReadPly(folder / "path.ply"));
  return PackPlan(plan.points_mm, BlockSizeOf(job.job()));
}

Result<std::string> ReadMade(const fs::path& folder, std::uint32_t from) {
  const fs::path file = folder / "journal.bin";
  const auto header = INTAGLIO_TRY(ReadPart(file, 0, formats::kJournalHeaderSize));
  const auto records = INTAGLIO_TRY(ReadPart(
      file,
      formats::kJournalHeaderSize + std::uint64_t{from} * formats::kJournalRecordSize,
      kMaxRecords * formats::kJournalRecordSize));
  return PackMade(std::as_bytes(std::span(header)), std::as_bytes(std::span(records)),
                  from);
}

}  // namespace intaglio::console
