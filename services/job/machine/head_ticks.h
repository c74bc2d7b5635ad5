#pragma once

// How a scan head (MachineSpec.scan_head) makes ticks of marks: for its driver, and for
// what is known of a job before it starts.

#include <string>
#include <vector>

#include "engrave/galvo/mark_ticks.h"
#include "engrave/mark/mark.h"
#include "proto/machine.pb.h"

namespace intaglio {

inline constexpr double kDefaultRunInSeconds = 0.0006;
/// A place of a web is predicted, so it keeps away from the border of the field.
inline constexpr double kWebBorderMm = 0.2;

/// It has an encoder of the web, and is to follow it.
bool FollowsWeb(const ScanHead& head);

/// How long before they are played ticks are sent.
double AheadSeconds(const ScanHead& head);
/// How long before a mark begins the photo eye has to see its print mark.
double EyeAheadSeconds(const ScanHead& head);

/// Absent fields are the defaults of machine.proto.
galvo::MarkTickOptions TickOptionsOf(const ScanHead& head, const mark::Pen& pen,
                                     double rate_hz);

/// How far places of marks may be off: by the scan head, else by the machine, um.
double MarkToleranceUm(const MachineSpec& machine);

/// Why the head cannot make dots of that length in rows, its laser switched while the
/// mirrors sweep at that speed, as the end of a sentence with a remedy; empty: it can.
/// Dots lie at whole ticks, half of one from their place at most.
std::string WhyNoDotRows(const MachineSpec& machine, double dot_mm, double speed_mm_s);

/// A mark as strokes, one for each pass. Frame: material, x of the piece less web_mm.
std::vector<galvo::MarkStroke> StrokesOf(const mark::Mark& mark, const mark::Pen& pen);

}  // namespace intaglio
