#pragma once

// The verdict of a report, by its figures and its warnings.

#include <filesystem>
#include <string>

#include "engrave/render/views.h"
#include "proto/report.pb.h"
#include "services/job/verdict/verdict.h"

namespace intaglio::client {

/// Errors are from where the points were asked for, moved or not: the tolerance of the
/// machine and that of the motion together, um.
double ToleranceUm(const PositionErrors& errors);

/// No two planned points are nearer than the job allows; one point alone has no spacing.
bool KeepsSpacing(const JobReport& report);
/// The measured one, "0.1000 mm"; of one point alone "none: one point".
std::string SpacingText(const JobReport& report);

/// Fills the verdict in: not_good with what is wrong; good_with_warnings with the
/// warnings that say that the piece may look wrong, or that the glass may break; good.
void Judge(JobReport& report);

VerdictKind KindOf(const Verdict& verdict);

/// For people: `good` of a verdict that is good, "GOOD, WITH WARNINGS", "NOT GOOD".
std::string VerdictTitle(const Verdict& verdict, const std::string& good);
render::Tone ToneOf(const Verdict& verdict);

/// Takes the warnings and the consent over from a report.json of any version; nothing of
/// a file that is not there or not readable. Older ones have sentences alone: notes.
void AddWarningsOf(const std::filesystem::path& report_file, JobReport& report);

}  // namespace intaglio::client
