#include "engrave/render/course_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/render/text.h"

namespace intaglio::render {
namespace {

constexpr int kSheetWidth = 1200, kEdge = 50, kSpeeds = 220;
constexpr double kMinContours = 150, kMaxContours = 800;
constexpr double kTextLine = 24;
constexpr double kToleranceShare = 1.0 / 40;
constexpr double kJumpRatio = 0.3;

struct PathExtent {
  Vec2 min_mm = Vec2::Zero(), size_mm = Vec2::Ones();
};

PathExtent PathExtentOf(const std::vector<std::vector<Vec2>>& paths_mm) {
  Box3 box;
  for (const auto& path : paths_mm)
    for (const Vec2& p : path) box.Extend(Vec3(p.x(), p.y(), 0));
  if (box.empty()) return {};
  return {box.min_mm.head<2>(), box.size_mm().head<2>().cwiseMax(1e-6)};
}

/// As high as the contours need it over the whole width.
int ContoursHeightOf(const CoursePicture& picture) {
  const Vec2 size_mm = PathExtentOf(picture.paths_mm).size_mm;
  const double wanted = (kSheetWidth - 2 * kEdge) * size_mm.y() / size_mm.x();
  return static_cast<int>(std::clamp(wanted, kMinContours, kMaxContours));
}

void DrawContours(const CoursePicture& picture, Canvas& canvas) {
  const PathExtent extent = PathExtentOf(picture.paths_mm);
  const double room = ContoursHeightOf(picture);
  const double scale =
      std::min((kSheetWidth - 2 * kEdge) / extent.size_mm.x(), room / extent.size_mm.y());
  const double by = CourseMagnification(picture);
  const auto at_px = [&](const Vec2& mm) {
    const Vec2 from_low = scale * (mm - extent.min_mm);
    return Vec2(kEdge + from_low.x(), kEdge + room - from_low.y());
  };
  for (const auto& path : picture.paths_mm) {
    for (std::size_t i = 1; i < path.size(); ++i)
      DrawLine(canvas, at_px(path[i - 1]), at_px(path[i]), 1, {Srgb(0x3f6f9f)});
  }
  for (const auto& course : picture.courses) {
    for (std::size_t i = 1; i < course.size(); ++i) {
      const CourseSample &p = course[i - 1], &q = course[i];
      // Where the nearest place jumps to the next leg, no line.
      if ((q.by_mm - p.by_mm).norm() > kJumpRatio * picture.tolerance_mm) continue;
      const bool over = q.by_mm.norm() > picture.tolerance_mm * 1.001;
      DrawLine(canvas, at_px(p.place_mm + by * p.by_mm), at_px(q.place_mm + by * q.by_mm),
               1.4, {Srgb(over ? 0xff5050 : 0xffb454)});
    }
  }
}

void DrawSpeeds(const CoursePicture& picture, int top_px, Canvas& canvas) {
  double length_mm = 1e-9, greatest = 1e-9;
  for (const auto& course : picture.courses) {
    for (const CourseSample& sample : course) {
      length_mm = std::max(length_mm, sample.s_mm);
      greatest = std::max(greatest, sample.speed_mm_s);
    }
  }
  const Rect frame{kEdge, top_px, kSheetWidth - 2 * kEdge, kSpeeds};
  FrameRect(canvas, frame, {Srgb(0x404a58)});
  const auto at_px = [&](const CourseSample& sample) {
    return Vec2(frame.x + frame.width * sample.s_mm / length_mm,
                frame.bottom() - 0.95 * frame.height * sample.speed_mm_s / greatest);
  };
  for (const auto& course : picture.courses)
    for (std::size_t i = 1; i < course.size(); ++i)
      DrawLine(canvas, at_px(course[i - 1]), at_px(course[i]), 1, {Srgb(0x7fd08a)});
  DrawText(canvas, {kEdge + 6.0, top_px - 10.0},
           fmt::format("speed along the path, greatest {:.1f} mm/s, {:.0f} mm of path",
                       greatest, length_mm),
           {10, Srgb(0xd8dee8)});
}

}  // namespace

double CourseMagnification(const CoursePicture& picture) {
  if (picture.tolerance_mm <= 0) return 1;
  const double wanted = kToleranceShare *
                        PathExtentOf(picture.paths_mm).size_mm.maxCoeff() /
                        picture.tolerance_mm;
  if (wanted <= 1) return 1;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  const double digit = wanted / power;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

Canvas DrawCourse(const CoursePicture& picture) {
  const auto lines = static_cast<int>(picture.figures.size());
  const int contours_px = ContoursHeightOf(picture) + 2 * kEdge;
  const int text_px = contours_px + kSpeeds + kEdge;
  Canvas canvas(kSheetWidth, text_px + static_cast<int>(kTextLine) * (lines + 2));
  FillRect(canvas, {0, 0, canvas.width(), canvas.height()}, {Srgb(0x10141a)});
  DrawText(canvas, {kEdge, 30}, picture.title, {14, Srgb(0xffffff)});
  DrawContours(picture, canvas);
  DrawSpeeds(picture, contours_px, canvas);
  const TextStyle plain{10, Srgb(0xd8dee8)};
  double y_px = text_px;
  DrawText(canvas, {kEdge, y_px},
           fmt::format("blue: the path; orange: the actual course, deviations {:g} times "
                       "as large; red: over the tolerance",
                       CourseMagnification(picture)),
           plain);
  for (const std::string& figure : picture.figures)
    DrawText(canvas, {kEdge, y_px += kTextLine}, figure, plain);
  return canvas;
}

}  // namespace intaglio::render
