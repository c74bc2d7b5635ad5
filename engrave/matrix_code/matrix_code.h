#pragma once

// Texts as codes of dark and bright modules: Data Matrix (ISO/IEC 16022, ECC 200, square)
// and QR (ISO/IEC 18004), encoded by the library zint.

#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::matrix_code {

enum class CodeKind { kDataMatrix, kQr };

struct CodeOptions {
  CodeKind kind = CodeKind::kDataMatrix;
  /// Of a QR the largest share of the code that may be damaged, 0..0.3: the next of its
  /// levels 0.07, 0.15, 0.25, 0.30 at or above it.
  double correction_ratio = 0.15;
};

/// Without the quiet rim that a reader needs around it: one module, of a QR four.
struct ModuleGrid {
  int columns = 0;
  int rows = 0;
  std::vector<bool> dark;  ///< columns * rows, row 0 on top

  /// False outside.
  bool IsDark(int column, int row) const {
    return column >= 0 && column < columns && row >= 0 && row < rows &&
           dark[static_cast<std::size_t>(row * columns + column)];
  }
};

/// Side of the quiet rim, in modules.
int QuietModules(CodeKind kind);

/// kMissing: an empty text; kUnreadable: it is not UTF-8 or has a character that cannot
/// be coded; kTooLarge: no code of this kind holds it; each with the text.
Result<ModuleGrid> MakeCode(std::string_view utf8, const CodeOptions& options);

/// The grid with a quiet rim around it, and bright and dark exchanged.
ModuleGrid Inverted(const ModuleGrid& grid, int rim);

/// Outlines of the dark areas, x to the right, y up, the lower left corner of the grid at
/// the origin, in modules. What is dark lies to the left: outer ones run
/// counterclockwise, holes clockwise. Dark modules that touch at a corner alone are
/// apart.
std::vector<std::vector<Vec2>> ModuleOutlines(const ModuleGrid& grid);

}  // namespace intaglio::matrix_code
