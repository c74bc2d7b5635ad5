#include "engrave/render/web/web_picture.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/render/text.h"

namespace intaglio::render {
namespace {

constexpr int kWebWidth = 1400, kWebEdge = 50;
constexpr double kMinWeb = 120, kMaxWeb = 800, kWebLine = 24;

Box3 ExtentOfMarks(const WebPicture& picture) {
  Box3 box;
  for (const auto& mark : picture.marks_mm)
    for (const Vec2& p : mark) box.Extend(Vec3(p.x(), p.y(), 0));
  if (box.empty()) box.Extend(Vec3::Zero());
  // The field at rest, at the left end.
  const double y_mm = box.center_mm().y();
  box.Extend(Vec3(box.min_mm.x() + picture.field_mm, y_mm + picture.field_mm / 2, 0));
  box.Extend(Vec3(box.min_mm.x(), y_mm - picture.field_mm / 2, 0));
  return box;
}

}  // namespace

Canvas DrawWeb(const WebPicture& picture) {
  const Box3 box = ExtentOfMarks(picture);
  const Vec2 size_mm = box.size_mm().head<2>().cwiseMax(1e-6);
  const double room = std::clamp((kWebWidth - 2 * kWebEdge) * size_mm.y() / size_mm.x(),
                                 kMinWeb, kMaxWeb);
  const double scale =
      std::min((kWebWidth - 2 * kWebEdge) / size_mm.x(), room / size_mm.y());
  const auto lines = static_cast<double>(picture.figures.size());
  Canvas canvas(kWebWidth,
                static_cast<int>(room + 2 * kWebEdge + kWebLine * (lines + 2)));
  FillRect(canvas, {0, 0, canvas.width(), canvas.height()}, {Srgb(0x10141a)});
  DrawText(canvas, {kWebEdge, 30}, picture.title, {14, Srgb(0xffffff)});
  const auto at_px = [&](const Vec2& mm) {
    const Vec2 from_low = scale * (mm - box.min_mm.head<2>());
    return Vec2(kWebEdge + from_low.x(), kWebEdge + room - from_low.y());
  };
  const Vec2 low_px = at_px({box.min_mm.x(), box.center_mm().y() - picture.field_mm / 2});
  const int side_px = static_cast<int>(scale * picture.field_mm);
  FrameRect(canvas,
            {static_cast<int>(low_px.x()), static_cast<int>(low_px.y()) - side_px,
             side_px, side_px},
            {Srgb(0x404a58)});
  const auto count =
      std::max<double>(1, static_cast<double>(picture.marks_mm.size()) - 1);
  for (std::size_t k = 0; k < picture.marks_mm.size(); ++k) {
    const auto& mark = picture.marks_mm[k];
    if (mark.empty()) continue;
    if (k > 0 && !picture.marks_mm[k - 1].empty())
      DrawLine(canvas, at_px(picture.marks_mm[k - 1].back()), at_px(mark.front()), 0.8,
               {Srgb(0x5a6472)});
    const bool missed = k < picture.missed.size() && picture.missed[k];
    const Color color = missed ? Srgb(0xff5050)
                               : Mix(Srgb(0x4f8fe0), Srgb(0xffc454),
                                     static_cast<float>(static_cast<double>(k) / count));
    for (std::size_t i = 1; i < mark.size(); ++i)
      DrawLine(canvas, at_px(mark[i - 1]), at_px(mark[i]), 1.6, {color});
  }
  const TextStyle plain{10, Srgb(0xd8dee8)};
  double y_px = room + 2 * kWebEdge;
  DrawText(
      canvas, {kWebEdge, y_px},
      "blue to yellow: the marks in their order; red: missed; grey: jumps, the field",
      plain);
  for (const std::string& figure : picture.figures)
    DrawText(canvas, {kWebEdge, y_px += kWebLine}, figure, plain);
  return canvas;
}

}  // namespace intaglio::render
