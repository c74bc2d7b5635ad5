#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/render/png_file.h"
#include "services/client/proof/marks/cut_evidence.h"

namespace intaglio::client {
namespace {

constexpr int kLargestSheetPx = 2000;
// The face around all cuts is the first piece that is found.
constexpr std::uint32_t kSheetRgb = 0xb07a48;
constexpr std::array<std::uint32_t, 6> kPieceRgb = {0xd9a441, 0xc96f5a, 0x6fa8a0,
                                                    0x9a8fc4, 0x8fb35c, 0xcf86a8};
constexpr std::uint32_t kShallowRgb = 0x3f5f49, kDeepRgb = 0x14241a, kThroughRgb = 0;

render::Color ColorOf(std::uint32_t piece, double depth_um, double thickness_um) {
  if (piece == 1) return render::Srgb(kSheetRgb);
  if (piece > 1) return render::Srgb(kPieceRgb[(piece - 2) % kPieceRgb.size()]);
  if (depth_um >= thickness_um) return render::Srgb(kThroughRgb);
  return render::Mix(render::Srgb(kShallowRgb), render::Srgb(kDeepRgb),
                     static_cast<float>(depth_um / thickness_um));
}

}  // namespace

Status WriteSheetPicture(const std::filesystem::path& file, const CutEvidence& evidence) {
  const proof::CutSheet& sheet = evidence.compared.sheet;
  const auto pieces = proof::PiecesOf(sheet);
  const double thickness_um = 1e3 * evidence.way.header.sheet_thickness_mm;
  const int columns = sheet.column_count(), rows = sheet.row_count();
  const int step = (std::max(columns, rows) + kLargestSheetPx - 1) / kLargestSheetPx;
  render::Canvas canvas((columns + step - 1) / step, (rows + step - 1) / step);
  const float share = 1.0F / static_cast<float>(step * step);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t cell =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
          static_cast<std::size_t>(column);
      render::Color& pixel = canvas.at(column / step, canvas.height() - 1 - row / step);
      pixel = pixel + share * ColorOf(pieces[cell], sheet.depth_um(cell), thickness_um);
    }
  }
  return render::WritePng(file, canvas);
}

}  // namespace intaglio::client
