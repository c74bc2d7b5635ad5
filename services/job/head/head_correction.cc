#include "services/job/head/head_correction.h"

#include <fmt/format.h>

#include <utility>

#include "engrave/core/try.h"
#include "engrave/galvo/files/correction_files.h"
#include "engrave/galvo/files/ct5.h"
#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/io/whole_file.h"

namespace intaglio {
namespace {

constexpr std::size_t kMaxCorrectionFile = 4 << 20;

}  // namespace

Result<galvo::FieldGrid> ReadCorrectionFile(const std::string& file, double field_mm) {
  const std::string bytes = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxCorrectionFile));
  if (file.ends_with(".ct5"))
    return galvo::GridOf(INTAGLIO_TRY(galvo::ReadCt5(bytes, file)));
  if (file.ends_with(".ctb")) return galvo::ReadCtb(bytes, file, 65536 / field_mm);
  if (file.ends_with(".cor")) return galvo::ReadCor(bytes, file);
  return Fail(ErrorCode::kUnsupported,
              fmt::format("'{}' is no correction file; give .ct5, .ctb or .cor", file),
              file);
}

Result<std::optional<galvo::CorrectionTable>> LoadCorrection(const ScanHead& head) {
  if (head.correction_file().empty()) return std::nullopt;
  const auto named = [](Error error) {
    error.message = "scan_head.correction_file: " + error.message;
    return error;
  };
  auto grid =
      ReadCorrectionFile(head.correction_file(), head.field_mm()).map_error(named);
  if (!grid) return tl::make_unexpected(grid.error());
  auto table =
      galvo::CorrectionTable::Make(std::move(*grid), galvo::Interpolation::kBilinear)
          .map_error(named);
  if (!table) return tl::make_unexpected(table.error());
  return std::optional(std::move(*table));
}

Result<galvo::FieldWindow> WindowOf(const ScanHead& head) {
  const auto commands = INTAGLIO_TRY(LoadCorrection(head));
  return commands ? galvo::FieldWindow(head.field_mm(), *commands)
                  : galvo::FieldWindow(head.field_mm());
}

std::string NarrowedText(const galvo::FieldWindow& window) {
  if (window.is_whole_field()) return "";
  return fmt::format(", with its correction a square of {:.2f} mm", window.square_mm());
}

}  // namespace intaglio
