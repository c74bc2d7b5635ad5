#pragma once

// The points of a job for a page, from the job's folder: the plan (path.ply, job.json)
// and what was made of it (journal.bin). All numbers little endian.
//
// The plan: plan_packer.h.
//
//   made     0     4  number of the journal's record to read from next
//            4   4 N  place in the order, and outcome (PointOutcome) * 2^29, of each
//            record
//                     of kind outcome, in the order of the journal

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::console {

/// The bits above the place of a point in the order.
inline constexpr std::uint32_t kOutcomeShift = 29;

/// `header`: the first 64 bytes of a journal;
/// `records`: bytes from record `from` on. kUnreadable: it is no journal.
Result<std::string> PackMade(std::span<const std::byte> header,
                             std::span<const std::byte> records, std::uint32_t from);

/// Bytes of the packed plan of a job's folder; only the header of its file is read.
Result<std::size_t> PlanBytes(const std::filesystem::path& folder);
/// The plan in a job's folder. kNotFound: it has none yet, or the folder is on another
/// computer.
Result<std::string> ReadPlan(const std::filesystem::path& folder);
/// What was made, from a record of the journal on; at most 65536 records at a time.
Result<std::string> ReadMade(const std::filesystem::path& folder, std::uint32_t from);

}  // namespace intaglio::console
