#include "services/job/checks/course_check.h"

#include <gtest/gtest.h>

#include <fstream>

#include "services/job/convert/mark_defaults.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

// A service checks a job whose defaults a client has filled in.
TEST(CourseCheck, ItsDefaultsPassForEverythingThatIsMade) {
  const auto file = test::FreshFolder() / "plate.svg";
  std::ofstream(file) << "<svg/>";
  for (int make = CourseMake_MIN; make <= CourseMake_MAX; ++make) {
    for (const bool laser : {false, true}) {
      SCOPED_TRACE(CourseMake_Name(static_cast<CourseMake>(make)));
      JobSpec job;
      job.mutable_course()->add_files(file.string());
      job.mutable_course()->set_make(static_cast<CourseMake>(make));
      if (laser) job.mutable_course()->set_power_ratio(0.5);
      *job.mutable_course() = WithDefaults(job.course());
      for (const Finding& found : CheckCourse(job)) ADD_FAILURE() << found.message;
    }
  }
}

TEST(CourseCheck, AVShapedToolPassesBeforeAndAfterItsWidthIsFilledIn) {
  const auto file = test::FreshFolder() / "plate.svg";
  std::ofstream(file) << "<svg/>";
  JobSpec job;
  Course& course = *job.mutable_course();
  course.add_files(file.string());
  course.set_tip_mm(0);
  course.set_tool_angle_deg(90);
  course.set_depth_mm(0.15);
  for (const Finding& found : CheckCourse(job)) ADD_FAILURE() << found.message;
  course = WithDefaults(course);
  EXPECT_NEAR(course.tool_diameter_mm(), 0.3, 1e-12) << "45 degrees a side";
  for (const Finding& found : CheckCourse(job)) ADD_FAILURE() << found.message;
  course.set_depth_mm(0.0001);
  course.clear_tool_diameter_mm();
  ASSERT_EQ(CheckCourse(job).size(), 1u);
  EXPECT_TRUE(CheckCourse(job)[0].message.starts_with("course.depth_mm: 0.0001 makes "));
}

TEST(CourseCheck, WhatIsOfOtherWorkIsRefused) {
  JobSpec job;
  job.mutable_course()->set_make(COURSE_MAKE_CUT);
  job.mutable_course()->set_pass_count(2);
  bool named = false;
  for (const Finding& found : CheckCourse(job))
    named = named || found.message.starts_with("course.pass_count: 2");
  EXPECT_TRUE(named);
}

}  // namespace
}  // namespace intaglio
