#pragma once

// The points of a job for a page, from the job's folder: the plan (path.ply, job.json)
// and what was made of it (journal.bin). All numbers little endian.
//
//   plan   offset  size
//             0     8  "INTPLAN1"
//             8     4  points N
//            12    12  size of the block x, y, z, mm, floats
//            24   8 N  x, y, z of each point and its place in the order, in 1/65535 of
//            the
//                      block's size and of N
//    24 + 8 N   4 N  place of each point in the order
//   The points are in a random order: every first part of them is a fair sample.
//
//   made     0     4  number of the journal's record to read from next
//            4   4 N  place in the order, and outcome (PointOutcome) * 2^29, of each
//            record
//                     of kind outcome, in the order of the journal

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::console {

/// `block_mm`: glass frame. At most 2^29 points, else kTooLarge.
Result<std::string> PackPlan(const PointList& path_mm, const Vec3& block_mm);

/// `header`: the first 64 bytes of a journal;
/// `records`: bytes from record `from` on. kUnreadable: it is no journal.
Result<std::string> PackMade(std::span<const std::byte> header,
                             std::span<const std::byte> records, std::uint32_t from);

/// The plan in a job's folder. kNotFound: it has none yet, or the folder is on another
/// computer.
Result<std::string> ReadPlan(const std::filesystem::path& folder);
/// What was made, from a record of the journal on; at most 65536 records at a time.
Result<std::string> ReadMade(const std::filesystem::path& folder, std::uint32_t from);

}  // namespace intaglio::console
