#pragma once

// What was burnt for one job of marks, among all that virtual scan heads have recorded. A
// head records every lit tick of one power-up in one file, whatever the job; the journal
// of a job has the power-ups and the runs in which it was marked.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "engrave/core/result.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/mark_record.h"

namespace intaglio::client {

/// In the folder of a shop: the record of the head that runs. Older ones, of which an
/// open job may have marks, are marks-POWERUP.rec.
inline constexpr const char* kMarkRecord = "marks.rec";
/// Ticks with this number belong to no mark of the job.
inline constexpr std::uint32_t kNoMark = 0xffffffff;

/// By the power-up that a journal has. `serial_number` is the profile's; that of the
/// truth file in the folder counts as well. Files without a readable header are nobody's.
std::map<std::uint32_t, std::filesystem::path> MarkRecordsIn(
    const std::filesystem::path& folder, const std::string& serial_number);

/// The job's ticks of these records, in the order of its power-ups: those of its runs,
/// and what was burnt between the first and the last of them by no run of it (kNoMark).
/// The ticks of a later power-up follow those of the one before, and its print marks lie
/// behind those of the one before. Nullopt when a power-up
/// has no record: it was a real machine's, or the record is lost. kUnreadable, kIo,
/// kTooLarge.
Result<std::optional<formats::MarkRecord>> FindBurnt(
    const formats::Journal& journal,
    const std::map<std::uint32_t, std::filesystem::path>& records);

/// All of a record that has this job alone; what belongs to no run of it is kNoMark.
Result<formats::MarkRecord> AllBurnt(const formats::Journal& journal,
                                     const std::filesystem::path& record);

/// Removes the kept records of other power-ups than these of journals.
void RemoveMarkRecords(const std::filesystem::path& folder,
                       const std::set<std::uint32_t>& needed);

}  // namespace intaglio::client
