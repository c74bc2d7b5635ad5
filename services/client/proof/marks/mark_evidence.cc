#include "services/client/proof/marks/mark_evidence.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/mark/mark_file.h"
#include "services/client/proof/evidence/proof_evidence.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/machine/head_ticks.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr double kNameChordMm = 0.01;

std::vector<Vec2> WayOf(const mark::Mark& mark, double chord_mm) {
  auto way = mark::PlacesOf(mark, chord_mm);
  if (mark.closed && way.size() > 1) way.push_back(way.front());
  return way;
}

Status CheckJournal(const fs::path& file, const formats::Journal& journal,
                    const mark::MarkSet& marks) {
  if (journal.header.point_count == marks.marks.size() &&
      journal.header.path_crc == mark::MarksCrc(marks))
    return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{}: is the journal of other marks ({}, {} has {}); put "
                          "the files of one job into the folder",
                          file.string(), Counted(journal.header.point_count, "mark"),
                          kMarksFile, marks.marks.size()),
              file.string());
}

}  // namespace

bool HasMarks(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / kMarksFile, error);
}

Result<MarkEvidence> ReadMarkEvidence(const fs::path& folder) {
  MarkEvidence evidence;
  evidence.job = INTAGLIO_TRY(ReadFrozenJob(folder / "job.json"));
  evidence.marks = INTAGLIO_TRY(mark::ReadMarkFile(folder / kMarksFile));
  const auto journal = INTAGLIO_TRY(formats::ReadJournal(folder / "journal.bin"));
  INTAGLIO_TRY(CheckJournal(folder / "journal.bin", journal, evidence.marks));
  evidence.history = formats::HistoryOf(journal);
  if (fs::exists(folder / kCutFile)) {
    evidence.has_material = true;
    evidence.cut =
        INTAGLIO_TRY(ReadCutEvidence(folder, evidence.job.job().course(), evidence.marks,
                                     MarkToleranceUm(evidence.job.machine())));
    evidence.compared = evidence.cut->compared.marks;
    evidence.account = proof::AccountMarks(evidence.history, evidence.compared);
    return evidence;
  }
  if (!fs::exists(folder / kBurntFile)) {
    evidence.account = proof::AccountMarks(evidence.history);
    return evidence;
  }
  auto record = INTAGLIO_TRY(formats::ReadMarkRecord(folder / kBurntFile));
  if (record.torn_bytes > 0) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: cut or damaged behind {}; remove it and verify the "
                    "folder again beside its shop",
                    (folder / kBurntFile).string(), Counted(record.ticks.size(), "tick")),
        (folder / kBurntFile).string());
  }
  evidence.has_material = true;
  evidence.burnt = std::move(record.ticks);
  const Marks marks = WithDefaults(evidence.job.job().marks());
  if (marks.web().has_eye()) {
    proof::PrintedRepeats repeats{
        {}, marks.repeats().pitch_mm(), marks.web().eye().offset_mm()};
    for (const formats::PrintMark& print : record.prints)
      repeats.prints_mm.push_back(print.place_mm);
    evidence.compared = proof::CompareMarks(evidence.marks, evidence.burnt, repeats);
  } else {
    evidence.compared =
        proof::CompareMarks(evidence.marks, evidence.burnt, evidence.on_web());
  }
  evidence.account = proof::AccountMarks(evidence.history, evidence.compared);
  return evidence;
}

MarkName NameOf(const MarkEvidence& evidence, std::size_t place) {
  const mark::Mark& mark = evidence.marks.marks[place];
  MarkName name;
  name.set_mark(static_cast<std::uint32_t>(place) + 1);
  name.set_item(evidence.marks.pens[mark.pen].name);
  const double pitch_mm = evidence.job.job().marks().repeats().pitch_mm();
  if (evidence.on_web()) {
    name.set_repeat(1 + static_cast<std::uint32_t>(
                            pitch_mm > 0 ? std::round(mark.web_mm / pitch_mm) : 0));
  }
  const Vec2 middle_mm = mark::MiddleOf(WayOf(mark, kNameChordMm));
  name.set_x_mm(middle_mm.x());
  name.set_y_mm(middle_mm.y());
  return name;
}

std::string MarkText(const MarkName& name) {
  const std::string repeat =
      name.repeat() > 0 ? fmt::format(", repeat {}", name.repeat()) : "";
  return fmt::format("mark {} ({}{}) at ({:.2f}, {:.2f}) mm", name.mark(), name.item(),
                     repeat, name.x_mm(), name.y_mm());
}

}  // namespace intaglio::client
