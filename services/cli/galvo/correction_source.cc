#include "services/cli/galvo/correction_source.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/galvo/files/correction_files.h"
#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/io/whole_file.h"

namespace intaglio::cli {
namespace {

constexpr std::uint64_t kMaxCorrectionBytes = 4 << 20;  // four times the largest kind

Result<galvo::CorrectionTable> Bilinear(Result<galvo::FieldGrid> grid) {
  if (!grid) return tl::unexpected(grid.error());
  return galvo::CorrectionTable::Make(*std::move(grid), galvo::Interpolation::kBilinear);
}

}  // namespace

Result<CorrectionSource> ReadCorrection(const std::string& file,
                                        std::optional<double> bit_per_mm) {
  const std::string kind = std::filesystem::path(file).extension().string();
  if (kind != ".ct5" && kind != ".ctb" && kind != ".cor") {
    return Fail(
        ErrorCode::kUnsupported,
        file + ": is no correction file; give one that ends in .ct5, .ctb or .cor", file);
  }
  const std::string bytes = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxCorrectionBytes));
  if (kind == ".ct5") {
    auto ct5 = INTAGLIO_TRY(galvo::ReadCt5(bytes, file));
    auto table = INTAGLIO_TRY(Bilinear(galvo::GridOf(ct5)));
    return CorrectionSource{std::move(table), std::move(ct5)};
  }
  if (kind == ".cor") {
    auto table = INTAGLIO_TRY(Bilinear(galvo::ReadCor(bytes, file)));
    return CorrectionSource{std::move(table), std::nullopt};
  }
  if (!bit_per_mm) {
    return Fail(ErrorCode::kMissing,
                file + ": does not have its calibration; give it with --table-bits");
  }
  auto table = INTAGLIO_TRY(Bilinear(galvo::ReadCtb(bytes, file, *bit_per_mm)));
  return CorrectionSource{std::move(table), std::nullopt};
}

}  // namespace intaglio::cli
