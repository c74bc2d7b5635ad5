#pragma once

// What gains do in the three regimes of Tirnovean 2016, simulated with converter,
// encoder, limit and friction: each regime asks for another answer.

#include <array>
#include <string>
#include <vector>

#include "proto/drive.pb.h"
#include "proto/drive_report.pb.h"
#include "services/job/drive/drive_profile.h"

namespace intaglio::cli {

/// The gains of each axis of a profile, in its order.
struct NamedLoops {
  std::string gains;  ///< "panel", "tuned"
  std::vector<drive::PositionLoop> loops;
};

/// Rapid: each axis' error when a move has ended and the time until it is small. Circle
/// and corner: how far the first two axes are from the path, R 30 mm and 90 degrees at
/// 2000 mm/min. A regime in which an axis is not stable has an answer without figures.
std::vector<RegimeAnswer> AnswersOf(const DriveProfile& profile, const NamedLoops& loops);

std::string AnswerText(const RegimeAnswer& answer);

}  // namespace intaglio::cli
