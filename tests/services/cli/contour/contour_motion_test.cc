// The motion of a course in time, and its animation.

#include "services/cli/contour/contour_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "engrave/image/image_file.h"
#include "engrave/io/csv.h"
#include "engrave/io/number_text.h"
#include "services/cli/contour/contour_figures.h"
#include "services/cli/contour/contour_frames.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/files/job_file.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

/// A disc of 2 mm and a hole, or a square of 20 mm.
struct SmallBoard {
  Course whole;
  ContourWork work;
};

SmallBoard DiscAndHole() {
  Course course;
  course.set_tool_diameter_mm(0.5);
  course.set_speed_mm_s(10);
  course.set_travel_mm_s(20);
  course.set_repeat_count(2);
  SmallBoard board{WithDefaults(course), {}};
  CourseFiles files;
  files.elements.push_back({contour::Circle{{3, 3}, 2}, "disc"});
  files.holes.push_back({{9, 3}, 0.8});
  auto work = MakeContourWork(board.whole, files, {0, 0});
  EXPECT_TRUE(work) << (work ? "" : work.error().message);
  board.work = std::move(*work);
  return board;
}

SmallBoard Square() {
  Course course;
  course.set_make(COURSE_MAKE_CURVES);
  course.set_speed_mm_s(60);
  course.set_power_ratio(0.5);
  SmallBoard board{WithDefaults(course), {}};
  CourseFiles files;
  files.curves.push_back(
      {"square",
       {contour::MakeLine({0, 0}, {20, 0}), contour::MakeLine({20, 0}, {20, 20}),
        contour::MakeLine({20, 20}, {0, 20}), contour::MakeLine({0, 20}, {0, 0})},
       true});
  auto work = MakeContourWork(board.whole, files, {0, 0});
  EXPECT_TRUE(work) << (work ? "" : work.error().message);
  board.work = std::move(*work);
  return board;
}

TEST(ContourMotion, WithoutAMachineItTakesTheTimeOfTheFigures) {
  const SmallBoard board = DiscAndHole();
  const auto motion = MotionOf(board.work, board.whole, nullptr, {0, 0});
  ASSERT_TRUE(motion) << motion.error().message;
  // The figures have the holes from the start, the motion from the last contour on.
  const Vec2 last = board.work.paths.back().begin_mm;
  const double from_start_s = Vec2(9, 3).norm() / 20;
  const double from_last_s = (Vec2(9, 3) - last).norm() / 20;
  EXPECT_NEAR(motion->duration_s - from_last_s,
              TimeOf(board.work, board.whole).sum_s() - from_start_s, 1e-9);
  EXPECT_NEAR(motion->work_s, 2 * 2 * std::numbers::pi * 1.25 / 10, 1e-9);
}

// The way between two instants is never longer than the speed allows, and at work every
// place is 1.25 mm from the middle of the disc.
TEST(ContourMotion, TheToolStaysOnItsWay) {
  const SmallBoard board = DiscAndHole();
  const auto motion = MotionOf(board.work, board.whole, nullptr, {0, 0});
  ASSERT_TRUE(motion);
  const int count = 5000;
  Vec2 before = motion->At(0).place_mm;
  int at_work = 0;
  for (int k = 1; k <= count; ++k) {
    const ToolState now = motion->At(motion->duration_s * k / count);
    EXPECT_LE((now.place_mm - before).norm(), 20 * motion->duration_s / count + 1e-9);
    before = now.place_mm;
    if (motion->legs[now.leg].kind != LegKind::kWork) continue;
    ++at_work;
    EXPECT_NEAR((now.place_mm - Vec2(3, 3)).norm(), 1.25, 1e-6);
    EXPECT_NEAR(now.speed_mm_s, 10, 1e-9);
  }
  EXPECT_NEAR(at_work, count * motion->work_s / motion->duration_s, 4);
  EXPECT_LT((before - Vec2(9, 3)).norm(), 1e-9) << "it ends at the hole";
}

TEST(ContourMotion, OnAMachineItSlowsDownForCorners) {
  const SmallBoard board = Square();
  MachineSpec machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
  machine.mutable_second_order()->set_natural_frequency_hz(30);
  machine.mutable_second_order()->set_damping_ratio(0.4);
  machine.set_position_tolerance_um(80);
  const auto motion = MotionOf(board.work, board.whole, &machine, {0, 0});
  ASSERT_TRUE(motion) << motion.error().message;
  EXPECT_EQ(motion->not_held, 0U);
  EXPECT_GT(motion->work_s, 80.0 / 60);
  EXPECT_LT(motion->work_s, 3 * 80.0 / 60);
  double fastest = 0, at_corner = 1e9;
  for (int k = 0; k <= 20000; ++k) {
    const ToolState now = motion->At(motion->duration_s * k / 20000);
    fastest = std::max(fastest, now.speed_mm_s);
    if ((now.place_mm - Vec2(20, 20)).norm() < 0.05)
      at_corner = std::min(at_corner, now.speed_mm_s);
    const Vec2 d = (now.place_mm - Vec2(10, 10)).cwiseAbs();
    EXPECT_NEAR(d.maxCoeff(), 10, 1e-6) << "on the square";
  }
  EXPECT_NEAR(fastest, 60, 0.1);
  EXPECT_LT(at_corner, 40);
}

// The last frame shows what the tool swept: a ring, by its area and its outer diameter.
TEST(ContourFrames, ShowWhatTheToolSwept) {
  SmallBoard board = DiscAndHole();
  board.work.rounds.clear();
  board.work.hole_count = 0;
  const auto motion = MotionOf(board.work, board.whole, nullptr, {0, 0});
  ASSERT_TRUE(motion);
  FrameOptions options;
  options.folder = test::FreshFolder() / "frames";
  options.step_s = motion->duration_s / 4;
  const auto count = WriteFrames(board.work, *motion, 0.5, options);
  ASSERT_TRUE(count) << count.error().message;
  EXPECT_EQ(*count, 5U);
  const auto table = io::ReadCsv(options.folder / "frames.csv");
  ASSERT_TRUE(table);
  ASSERT_EQ(table->rows.size(), 5U);
  EXPECT_NEAR(*io::ParseNumber(*table->Find(table->rows.back(), "time_s")),
              motion->duration_s, 1e-6);
  std::vector<double> areas;
  double extent_px = 0;
  for (int k = 1; k <= 5; ++k) {
    const std::string bytes =
        test::ContentOf(options.folder / ("frame_0000" + std::to_string(k) + ".png"));
    const auto image = image::ParseImage(bytes);
    ASSERT_TRUE(image) << k;
    double area = 0;
    int low = image->width, high = 0;
    for (int y = 0; y < image->height - 60; ++y) {  // below it is the caption
      for (int x = 0; x < image->width; ++x) {
        // White of the swept and orange of the tool; copper and ways are darker.
        if (image->at(x, y) < image::GreyImage::kWhite * 45 / 100) continue;
        ++area;
        low = std::min(low, x);
        high = std::max(high, x);
      }
    }
    areas.push_back(area);
    extent_px = high - low + 1;
  }
  EXPECT_TRUE(std::ranges::is_sorted(areas));
  EXPECT_LT(areas[0], areas[4] / 4);
  const double px_per_mm = extent_px / (2 * 1.25 + 0.5);
  EXPECT_NEAR(areas[4], 2 * std::numbers::pi * 1.25 * 0.5 * px_per_mm * px_per_mm,
              0.03 * areas[4]);
  options.step_s = 1e-6;
  const auto many = WriteFrames(board.work, *motion, 0.5, options);
  ASSERT_FALSE(many);
  EXPECT_NE(many.error().message.find("--frame-step: 1e-06 s make"), std::string::npos);
}

}  // namespace
}  // namespace intaglio::cli
