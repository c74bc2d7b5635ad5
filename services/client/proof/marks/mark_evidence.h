#pragma once

// The content of a finished job's folder where the job makes marks: job.json, the marks
// in their order, the journal, and what was burnt where the material is known.

#include <filesystem>
#include <optional>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/mark_record.h"
#include "engrave/mark/mark.h"
#include "engrave/proof/mark_account.h"
#include "engrave/proof/mark_comparison.h"
#include "proto/report.pb.h"
#include "proto/task.pb.h"
#include "services/client/proof/marks/cut_evidence.h"

namespace intaglio::client {

/// In a job's folder: its marks in their order, as the marker leaves them.
inline constexpr const char* kMarksFile = "marks.bin";
/// In a job's folder: what of the record of a virtual head's material belongs to it.
inline constexpr const char* kBurntFile = "burnt.rec";

struct MarkEvidence {
  FrozenJob job;
  mark::MarkSet marks;
  bool has_material = false;              ///< A real machine has no record of it.
  std::vector<formats::BurntTick> burnt;  ///< in the order of the record
  std::optional<CutEvidence> cut;  ///< of a mill or a cutter, in place of the ticks
  proof::MarkComparison compared;  ///< of them; empty without the material
  proof::MarkAccount account;
  std::vector<formats::PointHistory> history;

  bool on_web() const { return job.job().marks().has_web(); }
};

/// The folder has marks in place of points.
bool HasMarks(const std::filesystem::path& folder);

/// Errors name the file and what is wrong with it. kInvalidValue: the journal belongs to
/// other marks.
Result<MarkEvidence> ReadMarkEvidence(const std::filesystem::path& folder);

/// How reports name it: item by its pen, repeat by its place along the web, the middle of
/// its way.
MarkName NameOf(const MarkEvidence& evidence, std::size_t place);
/// "mark 17 (item 2, repeat 3) at (12.34, 5.60) mm".
std::string MarkText(const MarkName& name);

}  // namespace intaglio::client
