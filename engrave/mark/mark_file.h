#pragma once

// Marks in a file, in the order in which they are made; of a job, what its journal
// counts. All numbers little endian.
//
//   offset  size
//        0     8  "INTMRKS1"
//        8     4  CRC-32 of everything that follows
//       12     4  pens
//       16     8  marks
//   of each pen: length of its name (4), the name, speed, power, frequency (doubles),
//     passes (4), depth, plunge speed (doubles)
//   of each mark: pen (4), kind (4: 0 open, 1 closed, 2 a row with dark ways), place
//     along the web (double), places (4), of each place x, y, bulge (doubles), and of a
//     row whether the way behind it is dark (4: 0 or 1)

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mark/mark.h"

namespace intaglio::mark {

/// 1 GiB of marks.
inline constexpr std::uint64_t kMaxMarkFileBytes = std::uint64_t{1} << 30;

std::vector<std::byte> EncodeMarks(const MarkSet& set);
/// kUnreadable: it is not such a file, is cut or damaged, or fails CheckMarks.
Result<MarkSet> DecodeMarks(std::span<const std::byte> bytes);

/// CRC-32 that identifies the marks of a journal: the one in their file.
std::uint32_t MarksCrc(const MarkSet& set);

/// The file is there whole or not at all. kIo.
Status WriteMarkFile(const std::filesystem::path& file, const MarkSet& set);
/// Errors name the file: as of DecodeMarks, kNotFound, kIo, kTooLarge.
Result<MarkSet> ReadMarkFile(const std::filesystem::path& file);

}  // namespace intaglio::mark
