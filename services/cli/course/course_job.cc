#include "services/cli/course/course_job.h"

#include <utility>

#include "engrave/core/try.h"
#include "engrave/drawing/flatten.h"
#include "engrave/io/whole_file.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/flat_models.h"
#include "services/job/models/read_limits.h"

namespace intaglio::cli {
namespace {

/// Ends of curves that are one contour: below what a drawing program rounds to.
constexpr double kJoinMm = 0.01;

Result<course::Path> PathOf(const drawing::FlatCurve& curve, double feed_mm_s) {
  std::vector<course::Piece> pieces;
  Vec2 last = curve.points_mm.front().head<2>();
  const auto add = [&](const Vec3& point) {
    // Points that differ in z alone are one place of x and y.
    if ((point.head<2>() - last).norm() < course::kMinSegmentMm) return;
    last = point.head<2>();
    pieces.push_back({last, feed_mm_s});
  };
  for (const Vec3& point : curve.points_mm) add(point);
  if (curve.closed) add(curve.points_mm.front());
  return course::Path::Make(curve.points_mm.front().head<2>(), pieces);
}

}  // namespace

Result<std::vector<course::Path>> ReadContours(const std::string& file, double feed_mm_s,
                                               double size_limits, Warnings& warnings) {
  Model model;
  model.set_file(file);
  const auto kind = KindOf(model);
  if (!kind || *kind != ModelKind::kDrawing) {
    return Fail(
        ErrorCode::kUnsupported,
        file + ": is no drawing; give one that ends in .dxf, .svg, .hpgl, .plt or .nci",
        file);
  }
  const ReadLimits limits = ReadLimitsTimes(size_limits);
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, limits.max_file_bytes));
  auto drawing = ReadDrawing(file, text, limits.drawings, warnings);
  if (!drawing) return tl::unexpected(WithRemedy(drawing.error(), limits));
  auto flat = INTAGLIO_TRY(drawing::Flatten(*drawing));
  drawing::JoinOpenCurves(kJoinMm, flat);
  std::vector<course::Path> paths;
  for (const drawing::FlatCurve& curve : flat.curves) {
    if (curve.points_mm.size() < 2) continue;  // a point of the drawing
    auto path = PathOf(curve, feed_mm_s);
    if (path) {
      paths.push_back(std::move(*path));
    } else if (path.error().code != ErrorCode::kMissing) {
      return tl::unexpected(io::AboutFile(path.error(), file));
    }
  }
  if (paths.empty()) {
    return Fail(ErrorCode::kMissing, file + ": has no curve to cut", file);
  }
  return paths;
}

}  // namespace intaglio::cli
