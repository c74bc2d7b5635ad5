// Every number of a course whose rule has an option is set by it, within its range alone.

#include "services/cli/contour/contour_options.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "services/platform/fields/field_rules.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;

Result<Course> CourseWith(const std::vector<std::string>& words) {
  command_line::Program program("intaglio", "");
  ContourOptions options;
  AddContourOptions(program.root(), options);
  if (auto parsed = program.Parse(words); !parsed) return tl::unexpected(parsed.error());
  return TypedCourse(options);
}

TEST(ContourOptions, SetTheFieldsOfTheirRules) {
  int count = 0;
  for (const auto* field : FieldsOf(*Course::descriptor())) {
    const std::string& option = RuleOf(*field).option();
    if (option.empty()) continue;
    const NumberRange range = RangeOf(*field);
    const auto course = CourseWith({option, fmt::format("{}", range.max)});
    ASSERT_TRUE(course.has_value()) << course.error().message;
    EXPECT_TRUE(course->GetReflection()->HasField(*course, field)) << option;
    EXPECT_THAT(course->ShortDebugString(), HasSubstr(field->name() + ": "));
    EXPECT_FALSE(CourseWith({option, fmt::format("{}", range.max + 1)})) << option;
    ++count;
  }
  EXPECT_EQ(count, 18);
}

TEST(ContourOptions, ExcludeEachOther) {
  EXPECT_FALSE(CourseWith({"--power", "0.5", "--depth", "0.1"}));
  EXPECT_FALSE(CourseWith({"--tabs", "2", "--tab-distance", "3"}));
  EXPECT_FALSE(CourseWith({"--passes", "1.5"}));
}

}  // namespace
}  // namespace intaglio::cli
