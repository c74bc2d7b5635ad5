#include "services/cli/contour/contour_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/render/canvas.h"
#include "engrave/render/png_file.h"
#include "engrave/render/text.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
constexpr double kEdgePx = 24, kCaptionPx = 40;
const render::Color kGroundColor = render::Srgb(0x10141a);
const render::Color kCopperColor = render::Srgb(0x7a5a34);
const render::Color kToComeColor = render::Srgb(0x3f6f9f);
const render::Color kMadeColor = render::Srgb(0xe6ecf2);
const render::Color kIdleColor = render::Srgb(0x5a6472);
const render::Color kToolColor = render::Srgb(0xffb454);

/// Millimetres to pixels: all of the work fits, y up.
class FrameScale {
 public:
  FrameScale(const ContourMotion& motion, const ContourWork& work, double margin_mm,
             const FrameOptions& options) {
    for (const MotionLeg& leg : motion.legs) {
      Include(leg.begin_mm);
      for (const contour::Edge& edge : leg.edges) Include(edge);
    }
    for (const contour::Edges& edges : work.copper)
      for (const contour::Edge& edge : edges) Include(edge);
    low_mm_ -= Vec2::Constant(margin_mm);
    high_mm_ += Vec2::Constant(margin_mm);
    const Vec2 size_mm = high_mm_ - low_mm_;
    px_per_mm_ = std::min((options.width_px - 2 * kEdgePx) / size_mm.x(),
                          (options.height_px - 2 * kEdgePx - kCaptionPx) / size_mm.y());
  }

  Vec2 At(const Vec2& place_mm) const {
    return {kEdgePx + px_per_mm_ * (place_mm.x() - low_mm_.x()),
            kEdgePx + px_per_mm_ * (high_mm_.y() - place_mm.y())};
  }
  double Px(double mm) const { return px_per_mm_ * mm; }

  /// The part of an edge as lines shorter than a pixel's error.
  void Draw(render::Canvas& canvas, const contour::Edge& edge, double from_mm,
            double to_mm, double width_px, const render::Paint& paint) const {
    const double turn =
        edge.is_arc() ? (to_mm - from_mm) / std::max(edge.radius_mm, 1e-9) : 0;
    const int count = 1 + static_cast<int>(turn / 0.1);
    Vec2 last = contour::PointAt(edge, from_mm);
    for (int k = 1; k <= count; ++k) {
      const Vec2 next = contour::PointAt(edge, from_mm + (to_mm - from_mm) * k / count);
      render::DrawLine(canvas, At(last), At(next), width_px, paint);
      last = next;
    }
  }

 private:
  void Include(const Vec2& place_mm) {
    low_mm_ = low_mm_.cwiseMin(place_mm);
    high_mm_ = high_mm_.cwiseMax(place_mm);
  }
  void Include(const contour::Edge& edge) {
    for (int k = 0; k <= 4; ++k) Include(contour::PointAt(edge, edge.length_mm * k / 4));
  }

  Vec2 low_mm_{1e9, 1e9}, high_mm_{-1e9, -1e9};
  double px_per_mm_ = 1;
};

class Animation {
 public:
  Animation(const ContourWork& work, const ContourMotion& motion, double tool_mm,
            const FrameOptions& options)
      : motion_(motion),
        work_(work),
        scale_(motion, work, tool_mm, options),
        tool_mm_(tool_mm),
        made_(options.width_px, options.height_px) {
    render::FillRect(made_, {0, 0, made_.width(), made_.height()}, {kGroundColor});
    for (const contour::Edges& edges : work.copper) DrawWhole(edges, 1, {kCopperColor});
    for (const MotionLeg& leg : motion.legs) {
      if (leg.kind == LegKind::kWork) DrawWhole(leg.edges, 1, {kToComeColor});
    }
  }

  /// Ascending times.
  render::Canvas FrameAt(double time_s) {
    const ToolState now = motion_.At(time_s);
    while (leg_ < now.leg) {
      DrawLeg(motion_.legs[leg_], motion_.legs[leg_].length_mm);
      ++leg_;
      way_mm_ = 0;
    }
    DrawLeg(motion_.legs[now.leg], now.way_mm);
    way_mm_ = now.way_mm;
    render::Canvas frame = made_;
    render::DrawDisc(frame, scale_.At(now.place_mm),
                     std::max(4.0, scale_.Px(tool_mm_) / 2), {kToolColor, 0.9F});
    render::DrawText(
        frame, {kEdgePx, frame.height() - kEdgePx},
        fmt::format("{:.2f} of {:.2f} s   {}   {:.2f} mm/s   x {:.3f}  y {:.3f}", time_s,
                    motion_.duration_s, NameOf(motion_.legs[now.leg].kind),
                    now.speed_mm_s, now.place_mm.x(), now.place_mm.y()),
        {12, kMadeColor});
    return frame;
  }

 private:
  void DrawWhole(const contour::Edges& edges, double width_px,
                 const render::Paint& paint) {
    for (const contour::Edge& edge : edges)
      scale_.Draw(made_, edge, 0, edge.length_mm, width_px, paint);
  }

  /// From way_mm_ to to_mm.
  void DrawLeg(const MotionLeg& leg, double to_mm) {
    if (leg.kind == LegKind::kDrill && way_mm_ == 0) {
      const double diameter_mm = work_.rounds[leg.number].diameter_mm;
      render::DrawDisc(made_, scale_.At(leg.begin_mm),
                       std::max(2.0, scale_.Px(diameter_mm) / 2), {kMadeColor, 0.8F});
    }
    const bool work = leg.kind == LegKind::kWork;
    const double width_px = work ? std::max(1.0, scale_.Px(tool_mm_)) : 1;
    double begin_mm = 0;
    for (const contour::Edge& edge : leg.edges) {
      const double from_mm = std::clamp(way_mm_ - begin_mm, 0.0, edge.length_mm);
      const double end_mm = std::clamp(to_mm - begin_mm, 0.0, edge.length_mm);
      if (end_mm > from_mm)
        scale_.Draw(made_, edge, from_mm, end_mm, width_px,
                    {work ? kMadeColor : kIdleColor});
      begin_mm += edge.length_mm;
    }
  }

  const ContourMotion& motion_;
  const ContourWork& work_;
  FrameScale scale_;
  double tool_mm_;
  render::Canvas made_;
  std::size_t leg_ = 0;  ///< that was begun to draw
  double way_mm_ = 0;    ///< of it that is drawn
};

Result<std::size_t> FrameCount(const ContourMotion& motion, double step_s) {
  const double count = std::ceil(motion.duration_s / step_s - 1e-9) + 1;
  if (count <= static_cast<double>(kMaxFrames)) return static_cast<std::size_t>(count);
  return Fail(ErrorCode::kTooLarge,
              fmt::format("--frame-step: {:g} s make {:.0f} frames of {:.1f} s, {} are "
                          "allowed; choose {:.3g} s or more",
                          step_s, count, motion.duration_s, kMaxFrames,
                          motion.duration_s / (kMaxFrames - 1)));
}

}  // namespace

Result<std::size_t> WriteFrames(const ContourWork& work, const ContourMotion& motion,
                                double tool_diameter_mm, const FrameOptions& options) {
  if (motion.legs.empty() || motion.duration_s <= 0) return std::size_t{0};
  const double step_s = options.step_s.value_or(motion.duration_s / 100);
  const std::size_t count = INTAGLIO_TRY(FrameCount(motion, step_s));
  std::error_code error;
  fs::create_directories(options.folder, error);
  if (error) {
    return Fail(ErrorCode::kIo,
                fmt::format("--frames: {}: {}; name a folder that can be made",
                            options.folder.string(), error.message()));
  }
  std::string table = "frame,time_s,x_mm,y_mm,speed_mm_s,kind\n";
  Animation animation(work, motion, tool_diameter_mm, options);
  for (std::size_t k = 0; k < count; ++k) {
    const double time_s = std::min(step_s * static_cast<double>(k), motion.duration_s);
    const ToolState now = motion.At(time_s);
    table += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.4f},{}\n", k + 1, time_s,
                         now.place_mm.x(), now.place_mm.y(), now.speed_mm_s,
                         NameOf(motion.legs[now.leg].kind));
    INTAGLIO_TRY(render::WritePng(options.folder / fmt::format("frame_{:05}.png", k + 1),
                                  animation.FrameAt(time_s)));
  }
  INTAGLIO_TRY(io::WriteFileAtomically(options.folder / "frames.csv", table));
  return count;
}

}  // namespace intaglio::cli
