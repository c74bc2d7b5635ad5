#pragma once

// Positioners as short text, for tables of tests.

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "services/virtual_engraver/positioner.h"

namespace intaglio::virtual_engraver {

/// "X,Y,Z" of guides: head or block, with a - before it when it is backwards; or
/// "arm,PIVOT_DISTANCE_MM,ARM_LENGTH_MM,Z". Empty: the head on all three.
inline PositionerOptions PositionerOf(const std::string& text) {
  PositionerOptions options;
  if (text.empty()) return options;
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  const auto guide = [](const std::string& part) {
    return Guide{part.ends_with("block"), part.starts_with('-')};
  };
  options.has_arm = parts.at(0) == "arm";
  if (!options.has_arm) {
    options.guides = {guide(parts.at(0)), guide(parts.at(1)), guide(parts.at(2))};
    return options;
  }
  options.pivot_distance_mm = std::stod(parts.at(1));
  options.arm_length_mm = std::stod(parts.at(2));
  options.guides[2] = guide(parts.at(3));
  return options;
}

}  // namespace intaglio::virtual_engraver
