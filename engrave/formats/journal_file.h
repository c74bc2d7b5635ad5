#pragma once

// The journal of an engraving: which points were about to be fired, and the outcome of
// each. The synchronizer appends to it, across its restarts; reports, resume and checks
// read it. Fixed-size records with a checksum each, at fixed places: of a file that is
// cut anywhere, or whose last blocks reached the disk in another order, all intact
// records can be read.
//
//   offset  size  header (64 bytes)
//        0     8  "INTJRNL1"
//        8     4  version, 2
//       12     4  record size, 32
//       16     8  points of the job
//       24     8  epoch of the job
//       32     4  CRC-32 of the path: x, y, z of each point in the order, doubles, mm
//       36     4  station of the machine's loading, from 1; 0: its table takes one block
//       40    20  zero
//       60     4  CRC-32 of bytes 0..59
//
//   offset  size  record (32 bytes)
//        0     1  kind (JournalKind)
//        1     1  outcome (PointOutcome)
//        2     1  reason (idl SkipReason); of a mark MarkSkip
//        3     1  kind outcome: bit 0..3, channels 1..4 whose photosensor saw no flash;
//        else zero 4     4  run 8     8  tick; kinds consent and reopened: number of the
//        grant
//       16     4  point: place in the order
//       20     4  kind session: times an interlock was opened; kind outcome: measured
//                 energy of the pulse, float, mJ, 0: not measured; else zero
//       24     4  pulses counted by the controller
//       28     4  CRC-32 of bytes 0..27
// A record of kind session has at 16 the controller's power-up, at 24 the pulses that it
// had counted and that are not this job's, and at 20 how often key, door or stop button
// had been opened since that power-up. All numbers little endian.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::formats {

enum class JournalKind : std::uint8_t {
  kIntent = 1,    ///< the point may fire at this tick; on disk before it can
  kOutcome = 2,   ///< the outcome of the point
  kSession = 3,   ///< ticks after this record count from this power-up of the controller
  kConsent = 4,   ///< a person's: fire the uncertain points again, and those now armed
                  ///< that become uncertain
  kReopened = 5,  ///< an uncertain point is open again by such consent
};

enum class PointOutcome : std::uint8_t {
  kNone = 0,
  kMade = 1,
  kMissed = 2,     ///< fired, and no crack was seen
  kSkipped = 3,    ///< not fired; may be tried again
  kUncertain = 4,  ///< unknown whether or where it was fired; fired again only with a
                   ///< person's consent
  kLeftOut =
      5,  ///< not fired, and never will be: by the operator's choice, or as MarkSkip
};

/// Why a mark is left out where the operator did not choose it; the reason of its
/// outcome.
enum class MarkSkip : std::uint8_t {
  kNone = 0,
  kNoPrintMark = 1,  ///< of its repeat on the web
  kRepeatBegun = 2,  ///< its repeat was begun in an earlier run, and has left the head
};

/// A crack was tried: such a point is never fired again.
constexpr bool IsFired(PointOutcome outcome) {
  return outcome == PointOutcome::kMade || outcome == PointOutcome::kMissed;
}

constexpr bool IsOfPoint(JournalKind kind) {
  return kind == JournalKind::kIntent || kind == JournalKind::kOutcome ||
         kind == JournalKind::kReopened;
}

struct JournalRecord {
  JournalKind kind = JournalKind::kIntent;
  PointOutcome outcome = PointOutcome::kNone;
  std::uint8_t reason = 0;
  std::uint32_t run = 0;
  std::uint64_t tick = 0;   ///< kConsent, kReopened: number of the grant that carried the
                            ///< consent
  std::uint32_t point = 0;  ///< kSession: power-up
  std::uint32_t pulse_count = 0;
  std::uint32_t openings = 0;  ///< kSession alone
  /// kOutcome alone. Bit 0..3: channels 1..4 that missed; 0 of a missed pulse: not known.
  std::uint8_t missed_channels = 0;
  float measured_mj = 0;  ///< kOutcome alone: energy of the pulse; 0: not measured
  bool operator==(const JournalRecord&) const = default;
};

struct JournalHeader {
  std::uint64_t point_count = 0;
  std::uint64_t epoch = 0;
  std::uint32_t path_crc = 0;  ///< PathCrc of what is engraved
  std::uint32_t station = 0;   ///< which block of the table; 0: there is one
  bool operator==(const JournalHeader&) const = default;
};

/// CRC-32 of the coordinates of a path or a cloud, x y z as doubles, glass frame, mm, in
/// their order. It identifies the path of a journal and the points of a proof.
std::uint32_t PathCrc(const PointList& path_mm);

/// The power-up of a session record where a controller gives a text and no number: its
/// CRC-32, never 0; of an empty text 0, not known.
std::uint32_t PowerUpOfText(std::string_view text);

inline constexpr std::size_t kJournalHeaderSize = 64;
inline constexpr std::size_t kJournalRecordSize = 32;

std::array<std::byte, kJournalHeaderSize> EncodeJournalHeader(
    const JournalHeader& header);
std::array<std::byte, kJournalRecordSize> EncodeJournalRecord(
    const JournalRecord& record);

struct Journal {
  JournalHeader header;
  std::vector<JournalRecord> records;
  /// Bytes after the last whole record with a right checksum: a cut, never an error.
  std::uint64_t torn_bytes = 0;
  /// Unreadable records with readable ones behind them: the result of a power failure
  /// before a sync was confirmed, or of a damaged disk.
  std::uint64_t damaged_records = 0;
};

/// kUnreadable when the header is not a journal's.
Result<Journal> ParseJournal(std::span<const std::byte> bytes);
Result<Journal> ReadJournal(const std::filesystem::path& file);

/// Receives the records of a journal in their order. The header is the same each time.
using TakeJournalRecord =
    std::function<void(const JournalHeader& header, const JournalRecord& record)>;

/// The records of ReadJournal() one after another, without all of them at once. Returns
/// the header. Errors as ReadJournal().
Result<JournalHeader> ReadJournalRecords(const std::filesystem::path& file,
                                         const TakeJournalRecord& take);

/// What the journal records of each point, by place in the order. A proof holds one a
/// point, so it is kept small: 24 bytes.
struct PointHistory {
  std::uint64_t tick = 0;
  std::uint32_t power_up = 0;     ///< to which the tick belongs; 0: not known
  std::uint32_t fired_count = 0;  ///< outcomes made or missed
  float measured_mj = 0;
  PointOutcome outcome = PointOutcome::kNone;
  std::uint8_t reason = 0;
  std::uint8_t missed_channels = 0;  ///< of its last pulse, as in JournalRecord
  bool open_intent : 1 = false;      ///< an intent without an outcome: uncertain
  /// It was uncertain and has been reopened by a person's consent. Until it is fired it
  /// is unknown whether it holds a crack.
  bool reopened : 1 = false;
};
std::vector<PointHistory> HistoryOf(const Journal& journal);

/// The same from records one after another.
class PointHistories {
 public:
  void Receive(const JournalHeader& header, const JournalRecord& record);
  /// By place in the order, as many as the header has points; it ends the collection.
  std::vector<PointHistory> Finish(const JournalHeader& header);

 private:
  std::vector<PointHistory> of_points_;
  std::uint32_t power_up_ = 0;
};

}  // namespace intaglio::formats
