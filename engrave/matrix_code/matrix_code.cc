#include "engrave/matrix_code/matrix_code.h"

#include <fmt/format.h>
#include <zint.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include "engrave/core/check.h"

namespace intaglio::matrix_code {
namespace {

struct DeleteSymbol {
  void operator()(zint_symbol* symbol) const { ZBarcode_Delete(symbol); }
};
using Symbol = std::unique_ptr<zint_symbol, DeleteSymbol>;

/// Levels L, M, Q and H of a QR.
int LevelOf(double correction_ratio) {
  constexpr double kRatios[] = {0.07, 0.15, 0.25};
  int level = 1;
  for (const double ratio : kRatios) level += correction_ratio > ratio + 1e-9 ? 1 : 0;
  return level;
}

const char* NameOfKind(CodeKind kind) {
  return kind == CodeKind::kQr ? "QR code" : "Data Matrix";
}

Error EncodingError(int code, const zint_symbol& symbol, std::string_view utf8,
                    CodeKind kind) {
  if (code == ZINT_ERROR_TOO_LONG) {
    return {ErrorCode::kTooLarge,
            fmt::format("the text of {} bytes is too long for a {}; shorten it",
                        utf8.size(), NameOfKind(kind)),
            std::string(utf8)};
  }
  return {ErrorCode::kUnreadable,
          fmt::format("\"{}\" cannot be written as a {}: {}", utf8, NameOfKind(kind),
                      symbol.errtxt),
          std::string(utf8)};
}

ModuleGrid GridOf(const zint_symbol& symbol) {
  ModuleGrid grid{symbol.width, symbol.rows, {}};
  grid.dark.reserve(static_cast<std::size_t>(grid.columns * grid.rows));
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column)
      grid.dark.push_back(((symbol.encoded_data[row][column / 8] >> (column % 8)) & 1) !=
                          0);
  return grid;
}

}  // namespace

int QuietModules(CodeKind kind) { return kind == CodeKind::kQr ? 4 : 1; }

Result<ModuleGrid> MakeCode(std::string_view utf8, const CodeOptions& options) {
  Require(options.correction_ratio >= 0 && options.correction_ratio <= 0.3,
          "correction_ratio is {}, outside 0..0.3", options.correction_ratio);
  if (utf8.empty()) return Fail(ErrorCode::kMissing, "a code needs a text; give one");
  if (utf8.size() > ZINT_MAX_DATA_LEN)
    return tl::unexpected(EncodingError(ZINT_ERROR_TOO_LONG, {}, utf8, options.kind));
  const Symbol symbol(ZBarcode_Create());
  Require(symbol != nullptr, "no memory for a code of {} bytes", utf8.size());
  symbol->input_mode = UNICODE_MODE;
  if (options.kind == CodeKind::kQr) {
    symbol->symbology = BARCODE_QRCODE;
    symbol->option_1 = LevelOf(options.correction_ratio);
  } else {
    symbol->symbology = BARCODE_DATAMATRIX;
    symbol->option_3 = DM_SQUARE;
  }
  const int code =
      ZBarcode_Encode(symbol.get(), reinterpret_cast<const unsigned char*>(utf8.data()),
                      static_cast<int>(utf8.size()));
  if (code >= ZINT_ERROR)
    return tl::unexpected(EncodingError(code, *symbol, utf8, options.kind));
  return GridOf(*symbol);
}

ModuleGrid Inverted(const ModuleGrid& grid, int rim) {
  Require(rim >= 0, "the rim is {} modules", rim);
  ModuleGrid inverted{grid.columns + 2 * rim, grid.rows + 2 * rim, {}};
  for (int row = -rim; row < grid.rows + rim; ++row)
    for (int column = -rim; column < grid.columns + rim; ++column)
      inverted.dark.push_back(!grid.IsDark(column, row));
  return inverted;
}

}  // namespace intaglio::matrix_code
