#pragma once

// What is typed behind `intaglio contour`.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/post/template.h"
#include "proto/course.pb.h"
#include "services/job/course/course_files.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct ContourOptions {
  std::vector<std::string> files;
  std::string make = "isolation", order = "improved", corners = "sharp";
  std::string layer, mirror = "auto";
  std::optional<double> mirror_x_mm;
  std::vector<double> alignment_y_mm;
  double alignment_diameter_mm = 3;
  bool inside = false, replace_drill_units = false;
  /// Fields of the course that are numbers, by their number in the schema.
  std::map<int, std::optional<double>> numbers;
  std::optional<double> chord_um, axis_speed_deg_s;
  std::optional<std::uint32_t> max_bytes;
  std::vector<double> start_mm, origin_mm;
  std::vector<std::string> parameters;  ///< NAME=TEXT, of the templates
  bool chords = false;
  std::string mill_template, drill_template, out, picture, xml, frames, page, machine,
      drill_units;
  std::optional<double> frame_step_s, probe_step_mm;
  std::string height_map;
  std::vector<double> height_zero_mm;
  double size_limits = 1;
};

/// All but the files and the limits of sizes.
void AddContourOptions(command_line::Command contour, ContourOptions& options);

/// The fields of a course that are given on the command line.
Course TypedCourse(const ContourOptions& options);

/// kInvalidValue: one of --parameter that is not NAME=TEXT, or is given twice.
Result<post::Parameters> TypedParameters(const ContourOptions& options);

/// What is said of its files.
CourseFileOptions TypedFileOptions(const ContourOptions& options);

}  // namespace intaglio::cli
