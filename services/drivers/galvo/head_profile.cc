#include "services/drivers/galvo/head_profile.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "engrave/galvo/files/correction_files.h"
#include "engrave/galvo/files/ct5.h"
#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/io/whole_file.h"

namespace intaglio::drivers {
namespace {

constexpr std::size_t kMaxCorrectionFile = 4 << 20;

Error MissingHeadField(const char* field, const char* remedy) {
  return {ErrorCode::kMissing, fmt::format("scan_head.{}: is missing; {}", field, remedy),
          ""};
}

Result<galvo::FieldGrid> CorrectionGridOf(const ScanHead& head) {
  const std::string& file = head.correction_file();
  const std::string bytes = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxCorrectionFile));
  if (file.ends_with(".ct5"))
    return galvo::GridOf(INTAGLIO_TRY(galvo::ReadCt5(bytes, file)));
  if (file.ends_with(".ctb")) return galvo::ReadCtb(bytes, file, 65536 / head.field_mm());
  if (file.ends_with(".cor")) return galvo::ReadCor(bytes, file);
  return Fail(ErrorCode::kUnsupported,
              fmt::format("'{}' is no correction file; give .ct5, .ctb or .cor", file),
              file);
}

}  // namespace

std::vector<Error> CheckScanHead(const MachineSpec& machine) {
  std::vector<Error> errors;
  if (!machine.has_scan_head()) {
    errors.push_back({ErrorCode::kMissing,
                      "scan_head: is missing; the protocol scan-head needs field_mm, "
                      "jump_mm_s and servo_lag_s (deploy/machines/galvo.textproto)",
                      ""});
    return errors;
  }
  const ScanHead& head = machine.scan_head();
  if (!(head.field_mm() > 0))
    errors.push_back(MissingHeadField("field_mm", "give the width of the field, mm"));
  if (!(head.jump_mm_s() > 0))
    errors.push_back(MissingHeadField("jump_mm_s", "give the speed of jumps, mm/s"));
  if (head.lead_servo() && !(head.servo_lag_s() > 0)) {
    errors.push_back({ErrorCode::kInvalidValue,
                      "scan_head.lead_servo: needs servo_lag_s above 0; give the lag, or "
                      "lead_servo: false",
                      "true"});
  }
  if (head.follow_web() && !(head.encoder_count_um() > 0))
    errors.push_back(MissingHeadField("encoder_count_um",
                                      "follow_web needs an encoder; give its count, um"));
  if (errors.empty() && !head.correction_file().empty()) {
    if (const auto table = LoadCorrection(head); !table) errors.push_back(table.error());
  }
  return errors;
}

Result<std::optional<galvo::CorrectionTable>> LoadCorrection(const ScanHead& head) {
  if (head.correction_file().empty()) return std::nullopt;
  const auto named = [](Error error) {
    error.message = "scan_head.correction_file: " + error.message;
    return error;
  };
  auto grid = CorrectionGridOf(head).map_error(named);
  if (!grid) return tl::make_unexpected(grid.error());
  auto table =
      galvo::CorrectionTable::Make(std::move(*grid), galvo::Interpolation::kBilinear)
          .map_error(named);
  if (!table) return tl::make_unexpected(table.error());
  return std::optional(std::move(*table));
}

}  // namespace intaglio::drivers
