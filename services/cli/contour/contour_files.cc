#include "services/cli/contour/contour_files.h"

#include <unistd.h>

#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/cli/progress/background_meter.h"

namespace intaglio::cli {

Result<CourseFiles> ReadCourseFiles(const Course& course, double size_limits,
                                    Warnings& warnings,
                                    const CourseFileOptions& options) {
  const ReadLimits limits = ReadLimitsTimes(size_limits);
  std::vector<std::string> texts;
  for (const std::string& file : course.files())
    texts.push_back(INTAGLIO_TRY(io::ReadWholeFile(file, limits.max_file_bytes)));
  return CourseFilesOf(course, {texts.begin(), texts.end()}, limits, warnings, options);
}

Result<MadeContours> ContoursFromFiles(const Course& whole, double size_limits,
                                       const Vec2& start_mm, Warnings& warnings,
                                       const CourseFileOptions& options) {
  BackgroundMeter meter(std::cerr, isatty(STDERR_FILENO) != 0);
  meter.Begin("read");
  MadeContours made;
  made.files = INTAGLIO_TRY(ReadCourseFiles(whole, size_limits, warnings, options));
  meter.Begin("contours");
  made.work = INTAGLIO_TRY(MakeContourWork(
      whole, made.files, start_mm, {meter.Sink("contours"), meter.Sink("order")}));
  return made;
}

}  // namespace intaglio::cli
