#include "services/console/job_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/ply_points.h"
#include "services/client/proof/evidence/proof_evidence.h"
#include "services/console/plan_packer.h"
#include "services/job/fields/shapes.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxRecords = 65536;

template <typename Value>
void Append(std::string& bytes, Value value) {
  char raw[sizeof value];
  std::memcpy(raw, &value,
              sizeof value);  // a little-endian host, as the formats' readers
  bytes.append(raw, sizeof value);
}

tl::unexpected<Error> NotThere(const fs::path& file) {
  return Fail(ErrorCode::kNotFound,
              fmt::format("{} is not there: the job has no plan yet, or its folder is on "
                          "another computer",
                          file.string()),
              file.string());
}

Result<formats::PlyPoints> OpenPlan(const fs::path& folder) {
  const fs::path file = folder / "path.ply";
  if (!std::ifstream(file)) return NotThere(file);
  return formats::PlyPoints::Open(file);
}

Result<std::string> ReadPart(const fs::path& file, std::uint64_t offset,
                             std::size_t max_bytes) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return NotThere(file);
  in.seekg(static_cast<std::streamoff>(offset));
  std::string bytes(max_bytes, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(max_bytes));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return bytes;
}

}  // namespace

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

Result<std::size_t> PlanBytes(const fs::path& folder) {
  const auto points = INTAGLIO_TRY(OpenPlan(folder));
  return PackedPlanBytes(points.count());
}

Result<std::string> ReadPlan(const fs::path& folder) {
  auto points = INTAGLIO_TRY(OpenPlan(folder));
  const auto job = INTAGLIO_TRY(client::ReadFrozenJob(folder / "job.json"));
  PlanPacker packer =
      INTAGLIO_TRY(PlanPacker::Begin(points.count(), BlockSizeOf(job.job())));
  while (true) {
    const PointList piece = INTAGLIO_TRY(points.Next());
    if (piece.empty()) break;
    packer.Count(piece);
  }
  points.Rewind();
  while (true) {
    const PointList piece = INTAGLIO_TRY(points.Next());
    if (piece.empty()) break;
    INTAGLIO_TRY(packer.Place(piece));
  }
  return packer.Finish();
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
