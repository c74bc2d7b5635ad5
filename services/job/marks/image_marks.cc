#include "services/job/marks/image_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/discretize/picture/halftone_screen.h"
#include "engrave/image/image_file.h"
#include "engrave/image/resample.h"
#include "services/job/marks/item_place.h"

namespace intaglio {
namespace {

constexpr std::uint64_t kScreenSeed = 1;
constexpr double kMaxPixels = 20e6;  // 400 MB of dots

void AddStroke(double from_mm, double to_mm, double y_mm, bool back, MarkShapes& made) {
  if (back) std::swap(from_mm, to_mm);
  made.shapes.push_back({{{from_mm, y_mm}, {to_mm, y_mm}}, false});
}

/// One row of pixels; `row` counts from below.
void AddRow(const image::FloatImage& picture, int row, const MarkImage& item,
            MarkShapes& made) {
  const int from_above = picture.height - 1 - row;
  const double limit = item.threshold_ratio();
  const auto marked = [&](int column) {
    return (static_cast<double>(picture.at(column, from_above)) < limit) != item.invert();
  };
  const double d = item.distance_mm(), y_mm = (row + 0.5) * d;
  const bool back = item.bidirectional() && row % 2 == 1;
  const std::size_t begin = made.shapes.size();
  for (int column = 0; column < picture.width; ++column) {
    if (!marked(column)) continue;
    const int first = column;
    while (column < picture.width && marked(column)) ++column;
    AddStroke(first * d, column * d, y_mm, back, made);
  }
  if (back)
    std::reverse(made.shapes.begin() + static_cast<std::ptrdiff_t>(begin),
                 made.shapes.end());
}

MarkShapes RowShapes(const image::FloatImage& picture, const MarkImage& item) {
  MarkShapes made;
  for (int row = 0; row < picture.height; ++row) AddRow(picture, row, item, made);
  return made;
}

/// The dots of one row in their order along it.
void AddDotRow(std::span<const Vec2> dots, double half_mm, const DotRows& rows, bool back,
               MarkShapes& made) {
  const std::size_t begin = made.shapes.size();
  for (const Vec2& dot : dots) {
    const double from_mm = dot.x() - half_mm, to_mm = dot.x() + half_mm;
    std::vector<Vec2>* row =
        made.shapes.size() > begin ? &made.shapes.back().places_mm : nullptr;
    if (row != nullptr && from_mm <= row->back().x()) {  // they touch
      row->back().x() = to_mm;
    } else if (row != nullptr && from_mm - row->back().x() <= rows.max_gap_mm &&
               to_mm - row->front().x() <= rows.max_mm) {
      row->insert(row->end(), {{from_mm, dot.y()}, {to_mm, dot.y()}});
    } else {
      made.shapes.push_back({{{from_mm, dot.y()}, {to_mm, dot.y()}}, false, true});
    }
  }
  if (!back) return;
  const auto first = made.shapes.begin() + static_cast<std::ptrdiff_t>(begin);
  std::reverse(first, made.shapes.end());
  for (auto row = first; row != made.shapes.end(); ++row)
    std::ranges::reverse(row->places_mm);
}

MarkShapes DotRowShapes(std::vector<Vec2> dots, double half_mm, const DotRows& rows,
                        bool bidirectional) {
  std::ranges::sort(dots, {}, [](const Vec2& p) { return std::pair(p.y(), p.x()); });
  MarkShapes made;
  bool back = false;
  for (auto from = dots.begin(); from != dots.end();) {
    // Places of a row of the grid have the same y, bit for bit.
    const auto to =
        std::find_if(from, dots.end(), [&](const Vec2& p) { return p.y() != from->y(); });
    AddDotRow({from, to}, half_mm, rows, back, made);
    back = bidirectional && !back;
    from = to;
  }
  return made;
}

MarkShapes DotShapes(const image::FloatImage& picture, const MarkImage& item,
                     const std::optional<DotRows>& rows) {
  const double d = item.distance_mm(), half_mm = item.dot_mm() / 2;
  discretize::HalftoneGrid grid(picture.width * d, picture.height * d, d, false);
  grid.PlaceLayer(0, 1, picture);
  auto places = discretize::ScreenByErrors(
      grid,
      [&](float brightness) {
        return item.invert() ? double(brightness) : 1 - double(brightness);
      },
      kScreenSeed);
  if (rows) return DotRowShapes(std::move(places), half_mm, *rows, item.bidirectional());
  MarkShapes made;
  for (const Vec2& p : places)
    AddStroke(p.x() - half_mm, p.x() + half_mm, p.y(), false, made);
  return made;
}

/// With so many pixels that they are a distance wide once it is scaled and fitted.
Result<image::FloatImage> Scaled(const image::GreyImage& picture, const MarkItem& item,
                                 const MarkFile& file) {
  const double d = item.image().distance_mm();
  Box3 whole;
  whole.Extend(Vec3(0, 0, 0));
  whole.Extend(Vec3(picture.width * d, picture.height * d, 0));
  const double scale = ScaleOfItem(item.placement(), CornersOf(whole));
  const double width = std::max(1.0, std::round(picture.width * scale));
  const double height = std::max(1.0, std::round(picture.height * scale));
  if (width * height > kMaxPixels) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("image.distance_mm: {} makes {:.0f} x {:.0f} pixels of {}, "
                            "more than {:.0f}; use a larger distance or a smaller size",
                            d, width, height, file.name, kMaxPixels),
                fmt::format("{}", d));
  }
  return image::Resample(picture, static_cast<int>(width), static_cast<int>(height));
}

}  // namespace

Result<MarkShapes> ImageShapes(const MarkItem& item, const MarkFile& file,
                               const ReadLimits& limits,
                               const std::optional<DotRows>& rows) {
  const MarkImage& how = item.image();
  const bool dots = how.make() == MARK_IMAGE_MAKE_DOTS;
  image::ImageOptions reading;
  reading.limits = limits.images;
  reading.samples = dots ? image::Samples::kLinearLight : image::Samples::kAsStored;
  const auto picture = image::ParseImage(file.bytes, reading);
  if (!picture) {
    Error error = WithRemedy(picture.error(), limits);
    error.message = fmt::format("image.file: {}: {}", file.name, error.message);
    return tl::unexpected(error);
  }
  const auto scaled = INTAGLIO_TRY(Scaled(*picture, item, file));
  MarkShapes made = dots ? DotShapes(scaled, how, rows) : RowShapes(scaled, how);
  if (made.shapes.empty()) {
    return Fail(ErrorCode::kMissing,
                fmt::format("image.file: {} has nothing to mark: all of it is {}; use "
                            "invert or another threshold_ratio",
                            file.name, how.invert() ? "dark" : "bright"),
                file.name);
  }
  made.is_scaled = true;
  made.extent_mm.emplace();
  made.extent_mm->Extend(Vec3(0, 0, 0));
  made.extent_mm->Extend(
      Vec3(scaled.width * how.distance_mm(), scaled.height * how.distance_mm(), 0));
  return made;
}

}  // namespace intaglio
