#include "services/cli/contour/contour_files.h"

#include <string>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"

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

}  // namespace intaglio::cli
