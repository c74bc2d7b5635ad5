#pragma once

// What the row of an archive's table `backup` has of all its files.

#include <cstdint>
#include <string>
#include <vector>

#include "services/backup/archive.h"

namespace intaglio::backup {

/// Bytes of all files.
std::uint64_t SumOf(const std::vector<ArchivedFile>& files);
/// The sum of names, sizes and checksums: a row that is missing or changed changes it.
std::uint32_t Crc32Of(const std::vector<ArchivedFile>& files, const std::string& made_utc,
                      const std::string& results);

}  // namespace intaglio::backup
