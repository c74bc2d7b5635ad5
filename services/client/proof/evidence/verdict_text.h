#pragma once

// What a report is judged by, and its verdict as people read it.

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

VerdictKind KindOf(const Verdict& verdict);

/// For people: `good` of a verdict that is good, "GOOD, WITH WARNINGS", "NOT GOOD".
std::string VerdictTitle(const Verdict& verdict, const std::string& good);
render::Tone ToneOf(const Verdict& verdict);

}  // namespace intaglio::client
