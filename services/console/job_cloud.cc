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
#include "services/job/fields/channels.h"
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

/// Whole records of a journal.
struct Part {
  std::uint32_t next = 0;  ///< number of the record behind them
  std::vector<formats::JournalRecord> records;
};

Result<Part> ParsePart(std::span<const std::byte> header,
                       std::span<const std::byte> records, std::uint32_t from) {
  std::vector<std::byte> file(header.begin(), header.end());
  file.insert(file.end(), records.begin(), records.end());
  auto journal = INTAGLIO_TRY(formats::ParseJournal(file));
  const std::uint64_t whole =
      (records.size() - std::min<std::uint64_t>(journal.torn_bytes, records.size())) /
      formats::kJournalRecordSize;
  return Part{static_cast<std::uint32_t>(from + whole), std::move(journal.records)};
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
  const Part part = INTAGLIO_TRY(ParsePart(header, records, from));
  std::string bytes;
  Append(bytes, part.next);
  for (const formats::JournalRecord& record : part.records) {
    if (record.kind != formats::JournalKind::kOutcome || record.point >> kOutcomeShift)
      continue;
    Append(bytes, record.point | static_cast<std::uint32_t>(record.outcome)
                                     << kOutcomeShift);
  }
  return bytes;
}

Result<std::string> PackTicks(std::span<const std::byte> header,
                              std::span<const std::byte> records, std::uint32_t from) {
  const Part part = INTAGLIO_TRY(ParsePart(header, records, from));
  std::string bytes;
  Append(bytes, part.next);
  for (const formats::JournalRecord& record : part.records) {
    const bool is_session = record.kind == formats::JournalKind::kSession;
    const bool is_pulse = record.kind == formats::JournalKind::kOutcome &&
                          formats::IsFired(record.outcome) &&
                          record.point >> kOutcomeShift == 0;
    if (!is_session && !is_pulse) continue;
    Append(bytes, is_session ? kPowerUp : record.point);
    Append(bytes, is_session ? 0 : static_cast<std::uint32_t>(record.tick));
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

namespace {

Result<std::string> ReadJournalPart(const fs::path& folder, std::uint32_t from,
                                    decltype(&PackMade) pack) {
  const fs::path file = folder / "journal.bin";
  const auto header = INTAGLIO_TRY(ReadPart(file, 0, formats::kJournalHeaderSize));
  const auto records = INTAGLIO_TRY(ReadPart(
      file,
      formats::kJournalHeaderSize + std::uint64_t{from} * formats::kJournalRecordSize,
      kMaxRecords * formats::kJournalRecordSize));
  return pack(std::as_bytes(std::span(header)), std::as_bytes(std::span(records)), from);
}

}  // namespace

Result<std::string> ReadMade(const fs::path& folder, std::uint32_t from) {
  return ReadJournalPart(folder, from, &PackMade);
}

Result<std::string> ReadTicks(const fs::path& folder, std::uint32_t from) {
  return ReadJournalPart(folder, from, &PackTicks);
}

Result<std::string> ReadChannels(const fs::path& folder) {
  auto points = INTAGLIO_TRY(OpenPlan(folder));
  const auto job = INTAGLIO_TRY(client::ReadFrozenJob(folder / "job.json"));
  std::string bytes;
  while (true) {
    const formats::PointTable piece = INTAGLIO_TRY(points.NextRows());
    if (piece.points_mm.empty()) return bytes;
    const auto* source = piece.Find<std::uint32_t>("source");
    if (source == nullptr) {
      return Fail(ErrorCode::kUnreadable,
                  "path.ply: does not have the models of its points; make the job again");
    }
    const auto masks = INTAGLIO_TRY(ChannelsOfPoints(job.job(), *source));
    bytes.append(masks.begin(), masks.end());
  }
}

}  // namespace intaglio::console
