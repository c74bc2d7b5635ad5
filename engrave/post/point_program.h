#pragma once

// The program of a cloud for a controller of another maker: a move to every point in its
// order, and one pulse there, by a template (template.h). Which pulse a controller can
// place where is measured (docs/machines): most stop at every point; one that switches
// its laser only in motion makes a short mark through the point.
//
// Fragments: `begin`, `point` (required) and `end`, once before, for every point, and
// once behind. Variables:
//   NAME            text, begin and end: the job's name
//   COUNT           begin and end: the number of points
//   I               point: its place in the order, from 1
//   X Y Z           point: its place, in the controller's axes
//   SX SY SZ        point: where the mark through it begins, half of `mark` before
//   EX EY EZ        point: where it ends
//   POWER           the laser's setting, 0..1 of its largest
//   N               number of the line, from 1, counted through the program
// Axes in mm, turning axes in degrees. Settings:
//   mark            length of the mark, mm, 0.0001..1: needed by SX..EZ. Its direction is
//                   that from the point before, that of the first along the first axis
//   flat            the template has no Z: points may differ in it by this much, mm
//   turning         so many of the first axes turn, 0..3, default 0; it has to be as on
//                   the machine, because the letters of axes that turn are others

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/post/template.h"

namespace intaglio::post {

/// Errors as of ParseTemplate; besides a template that does not use X or SX and EX (and
/// so on, Z only without `flat`), or uses the mark's ends without `mark`.
Result<Template> ParsePointTemplate(std::string_view text, std::string_view file);

struct PointProgram {
  std::string name;  ///< of the job; line breaks and control characters become spaces
  PointList axes;    ///< N x 3, one point per row: places of the axes, mm or degrees
  int turning_count = 0;   ///< of the first axes that turn, 0..3
  double power_ratio = 1;  ///< setting of the laser for the job's pulse energy, 0..1
  /// Of each point, where they differ; begin and end have power_ratio.
  std::vector<double> power_ratios = {};
};

/// Writes the program atomically, in constant memory. kUnsupported: a template for other
/// axes, a mark on an axis that turns, a template without Z for points at several depths,
/// or without POWER in `point` for points of several powers; else errors of the disk. The
/// axes have to be finite.
Status WritePointProgram(const std::filesystem::path& file, const Template& program,
                         const PointProgram& points);

}  // namespace intaglio::post
