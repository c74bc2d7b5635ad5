#pragma once

// What earlier lives of the synchronizer left of a job: its journal is read once, when
// the job is taken up, and then continued.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "engrave/formats/journal_file.h"
#include "services/cell/journal_writer.h"

namespace intaglio::cell {

struct EarlierWork {
  /// By place in the order; empty: no run ever began.
  std::vector<formats::PointHistory> points;
  std::uint32_t power_up = 0;  ///< of the controller, at the newest session; 0: none
  std::uint32_t pulses_before_job = 0;  ///< that it had counted by then, modulo 2^32
  std::uint32_t openings = 0;           ///< of interlocks, that had been seen by then
  std::uint32_t highest_run = 0;
  std::uint32_t run_count = 0;  ///< runs of which something was armed
  /// Points became uncertain, and no run has begun since.
  bool uncertain_unanswered = false;
  /// Greatest grant whose consent to fire uncertain points was taken: it counts once.
  std::uint64_t consent_grant = 0;
  std::uint64_t damaged_records = 0;
};

EarlierWork EarlierWorkOf(const formats::Journal& journal);

struct OpenedJournal {
  std::unique_ptr<JournalWriter> writer;
  EarlierWork earlier;
};

/// What a job leaves on the disk from its beginning: the journal, and then its path.
enum class JobBegun : std::uint8_t { kNo, kItsPathIsThere };

/// Begins the journal, or goes on with the one that is there. kRefused when it has
/// pulses made along another path (the block in the machine is not as this job left it),
/// kUnreadable when it may hold pulses and cannot be read, or is gone though the job was
/// begun; kIo.
Result<OpenedJournal> OpenJournal(const std::filesystem::path& file,
                                  const formats::JournalHeader& header, JobBegun begun);

}  // namespace intaglio::cell
