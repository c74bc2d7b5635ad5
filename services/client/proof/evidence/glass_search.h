#pragma once

// The cracks and collisions of one job among all that virtual engravers have recorded. An
// engraver records every crack of one power-up in one file, whatever the job; the journal
// of a job has the power-ups and the ticks at which it was engraved.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/formats/glass_record.h"
#include "engrave/formats/journal_file.h"

namespace intaglio::client {

/// In the folder of a shop: the record of the engraver that runs. Older ones, of which an
/// open job may have cracks, are glass-POWERUP.rec.
inline constexpr const char* kGlassRecord = "glass.rec";

/// When a job had the laser: from the beginning of its first session of a power-up to the
/// last tick at which a point could fire.
struct TickSpan {
  std::uint32_t power_up = 0;
  std::uint64_t first_tick = 0, last_tick = 0;
};

/// Collects the spans of a journal from its records one after another.
class TickSpans {
 public:
  void Receive(const formats::JournalRecord& record);
  /// One for each power-up, in the order of the journal; those without a tried point are
  /// left out. It ends the collection.
  std::vector<TickSpan> Finish();

 private:
  void EndSession();

  std::vector<TickSpan> spans_;
  TickSpan session_;
  bool tried_ = false;  ///< in the session
};

/// Errors as formats::ReadJournal().
Result<std::vector<TickSpan>> ReadTickSpans(const std::filesystem::path& journal);

/// What happened to the glass while a job had the laser. The cracks are those in the
/// glass, one value each in the columns that glass.ply has.
struct JobGlass {
  PointList cracks_mm;
  std::vector<double> ticks;
  std::vector<std::uint8_t> channels, stations;
  std::vector<formats::GlassCollision> collisions;

  void Reserve(std::size_t count);
  void Add(const formats::GlassCrack& crack);
};

/// All of an engraver's record. kNotFound, kUnreadable, kIo.
Result<JobGlass> AllGlass(const std::filesystem::path& record);

/// From the records in the folder, in the order of the spans. The ticks of a later
/// power-up follow those of the one before. Nullopt when a power-up has no record there:
/// it was a real machine's, or the record is lost. kUnreadable, kIo.
Result<std::optional<JobGlass>> FindGlass(const std::vector<TickSpan>& spans,
                                          const std::filesystem::path& folder);

/// Gives the record of an earlier engraver its own name, so that another one can begin.
Status KeepGlassRecord(const std::filesystem::path& record);

/// The same of the record of what a scan head burnt, as marks-POWERUP.rec.
Status KeepMarkRecord(const std::filesystem::path& record);

/// Removes the kept records of other power-ups.
void RemoveGlassRecords(const std::filesystem::path& folder,
                        const std::set<std::uint32_t>& needed);

}  // namespace intaglio::client
