#include "services/job/models/code_model.h"

#include <utility>

#include "engrave/core/try.h"

namespace intaglio {
namespace {

/// At corner i of an outline, which has the dark area to its left and turns by 90 degrees
/// at every corner: the sum of the normals of both sides, which has the coordinates +-1.
Vec2 InwardAt(const std::vector<Vec2>& outline, std::size_t i) {
  const std::size_t count = outline.size();
  const Vec2 to = (outline[i] - outline[(i + count - 1) % count]).normalized();
  const Vec2 from = (outline[(i + 1) % count] - outline[i]).normalized();
  return {-to.y() - from.y(), to.x() + from.x()};
}

}  // namespace

Result<matrix_code::ModuleGrid> GridOf(const MarkCode& code) {
  matrix_code::CodeOptions options;
  options.kind = code.kind() == MARK_CODE_KIND_QR ? matrix_code::CodeKind::kQr
                                                  : matrix_code::CodeKind::kDataMatrix;
  options.correction_ratio = code.correction_ratio();
  auto grid = matrix_code::MakeCode(code.text(), options);
  if (!grid) {
    Error error = grid.error();
    error.message = "code.text: " + error.message;
    return tl::unexpected(std::move(error));
  }
  if (code.invert())
    return matrix_code::Inverted(*grid, matrix_code::QuietModules(options.kind));
  return grid;
}

Result<drawing::Drawing> OutlineCode(const MarkCode& code, double inset_mm) {
  const auto grid = INTAGLIO_TRY(GridOf(code));
  drawing::Drawing drawing;
  for (const std::vector<Vec2>& outline : matrix_code::ModuleOutlines(grid)) {
    drawing::Polyline line;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vec2 inward = InwardAt(outline, i);
      const Vec2 p = code.module_mm() * outline[i] + inset_mm * inward;
      line.points_mm.emplace_back(p.x(), p.y(), 0);
    }
    drawing::Curve curve;
    curve.pieces.emplace_back(std::move(line));
    curve.closed = true;
    drawing.curves.push_back(std::move(curve));
  }
  return drawing;
}

}  // namespace intaglio
