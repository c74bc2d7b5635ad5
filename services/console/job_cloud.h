#pragma once

// The points of a job for a page, from the job's folder: the plan (path.ply, job.json)
// and what was made of it (journal.bin). All numbers little endian.
//
// The plan: plan_packer.h.
//
//   made     0     4  number of the journal's record to read from next
//            4   4 N  place in the order, and outcome (PointOutcome) * 2^29, of each
//                     record of kind outcome, in the order of the journal
//
//   ticks    0     4  number of the journal's record to read from next
//            4   8 N  place in the order, and the lower 32 bits of the tick, of each
//                     record of kind outcome that fired; 2^32 - 1, and 0, where the
//                     ticks count from another power-up of the controller
//
//   channels 0     N  channels in which each point is made, by its place in the order:
//                     bit 0..3, channels 1..4

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::console {

/// In place of the place of a point: another power-up of the controller.
inline constexpr std::uint32_t kPowerUp = 0xffffffff;

/// The bits above the place of a point in the order.
inline constexpr std::uint32_t kOutcomeShift = 29;

/// `header`: the first 64 bytes of a journal;
/// `records`: bytes from record `from` on. kUnreadable: it is no journal.
Result<std::string> PackMade(std::span<const std::byte> header,
                             std::span<const std::byte> records, std::uint32_t from);
/// The same of its ticks.
Result<std::string> PackTicks(std::span<const std::byte> header,
                              std::span<const std::byte> records, std::uint32_t from);

/// Bytes of the packed plan of a job's folder; only the header of its file is read.
Result<std::size_t> PlanBytes(const std::filesystem::path& folder);
/// The plan in a job's folder. kNotFound: it has none yet, or the folder is on another
/// computer.
Result<std::string> ReadPlan(const std::filesystem::path& folder);
/// What was made, from a record of the journal on; at most 65536 records at a time.
Result<std::string> ReadMade(const std::filesystem::path& folder, std::uint32_t from);

/// At which ticks, from a record of the journal on; as many at a time.
Result<std::string> ReadTicks(const std::filesystem::path& folder, std::uint32_t from);
/// In which channels. kUnreadable, kFault: the plan does not have the job's models.
Result<std::string> ReadChannels(const std::filesystem::path& folder);

}  // namespace intaglio::console
