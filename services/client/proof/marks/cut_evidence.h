#pragma once

// What a virtual mill or laser cutter did to its sheet, beside the marks of its job: the
// machine's own record in the job's folder, its figures and its picture.

#include <filesystem>
#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "engrave/proof/cut_comparison.h"
#include "proto/job.pb.h"
#include "proto/report.pb.h"
#include "proto/truth.pb.h"

namespace intaglio::client {

/// In a job's folder: the record of the tool (engrave/formats/tool_way.h).
inline constexpr const char* kCutFile = "cut.rec";
/// In the folder of the processes: of the machine that runs.
inline constexpr const char* kCutRecord = "cuts.rec";
/// In a job's folder: the sheet from above.
inline constexpr const char* kSheetFile = "sheet.png";

struct CutEvidence {
  formats::ToolWay way;
  double planned_diameter_mm = 0;
  proof::CutComparison compared;
};

/// The diameter of the tool that makes the course: its holes, or its contours. With
/// defaults, mm.
double ToolDiameterOf(const Course& course);

/// Reads kCutFile of a job's folder and compares it with the marks. kUnreadable: it is
/// cut or damaged.
Result<CutEvidence> ReadCutEvidence(const std::filesystem::path& folder,
                                    const Course& course, const mark::MarkSet& marks,
                                    double tolerance_um);

CutReport CutReportOf(const CutEvidence& evidence);
/// What is wrong with it: a sentence for each kind of fault.
void AddCutFaults(const CutReport& cut, Verdict& verdict);
/// Lines of the terminal.
std::string CutLines(const CutReport& cut);

/// What the tool left, from above: each piece of the face in a colour of its own, what is
/// cleared the darker the deeper, black where it is through. kIo.
Status WriteSheetPicture(const std::filesystem::path& file, const CutEvidence& evidence);

}  // namespace intaglio::client
