#include "engrave/render/course_picture.h"

#include <gtest/gtest.h>

namespace intaglio::render {
namespace {

CoursePicture Line(double by_mm) {
  CoursePicture picture;
  picture.paths_mm = {{Vec2(0, 0), Vec2(40, 0), Vec2(40, 40)}};
  picture.tolerance_mm = 0.1;
  std::vector<CourseSample> course;
  for (double x = 0; x <= 40; x += 0.5)
    course.push_back({Vec2(x, 0), Vec2(0, by_mm), x, 50});
  picture.courses = {course};
  return picture;
}

/// Pixels of the contours' part with this much more red than blue.
int CountOf(const Canvas& canvas, float min_red, float max_green) {
  int count = 0;
  for (int y = 40; y < 880; ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      const Color& c = canvas.at(x, y);
      count += c.r > min_red && c.g < max_green && c.b < 0.3F ? 1 : 0;
    }
  }
  return count;
}

TEST(CoursePicture, MagnifiesByARoundNumber) {
  // A fortieth of 40 mm is 1 mm: ten times the tolerance.
  EXPECT_EQ(CourseMagnification(Line(0)), 10);
  CoursePicture small = Line(0);
  small.paths_mm = {{Vec2(0, 0), Vec2(1, 1)}};
  EXPECT_EQ(CourseMagnification(small), 1);
}

TEST(CoursePicture, ShowsWhatIsOverTheToleranceInRed) {
  EXPECT_EQ(CountOf(DrawCourse(Line(0.09)), 0.5F, 0.2F), 0);
  EXPECT_GT(CountOf(DrawCourse(Line(0.15)), 0.5F, 0.2F), 300);
}

}  // namespace
}  // namespace intaglio::render
