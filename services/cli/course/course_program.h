#pragma once

// All contours of a drawing planned, with their sums and what is written about them.

#include <string>
#include <vector>

#include "engrave/course/margin.h"
#include "engrave/render/course_picture.h"
#include "proto/drive_report.pb.h"

namespace intaglio::cli {

struct PlannedContour {
  course::Path path;
  course::CoursePlan plan;
  course::Margin margin;
  double planned_ratio = 1;
};

struct CourseProgram {
  course::AxisPair axes;
  course::PlanOptions options;
  course::ModelError error;
  std::vector<PlannedContour> contours;
  double stopping_s = 0;  ///< with a stop at every node and the same acceleration

  bool holds() const;
  double duration_s() const;
  double length_mm() const;
};

/// `reserve`: plans each contour so that it holds with the mechanics wrong by `error`.
Result<CourseProgram> PlanProgram(std::vector<course::Path> paths,
                                  const course::AxisPair& axes,
                                  const course::PlanOptions& options,
                                  const course::ModelError& error, bool reserve);

/// Lines of name and value, as `intaglio plan` prints them.
std::vector<std::string> FiguresOf(const CourseProgram& program);

/// The same figures for programs.
CoursePlan ReportOf(const CourseProgram& program);

/// The table of the courses: one row for each setpoint.
Status WriteCourseTable(const std::string& file, const CourseProgram& program);

render::CoursePicture PictureOf(const CourseProgram& program, const std::string& title);

}  // namespace intaglio::cli
