#include "services/drivers/galvo/head_profile.h"

#include <fmt/format.h>

#include "services/job/head/head_correction.h"
#include "services/job/machine/head_ticks.h"

namespace intaglio::drivers {
namespace {

Error MissingHeadField(const char* field, const char* remedy) {
  return {ErrorCode::kMissing, fmt::format("scan_head.{}: is missing; {}", field, remedy),
          ""};
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
  if (head.has_eye_mm() && !FollowsWeb(head))
    errors.push_back(MissingHeadField("encoder_count_um",
                                      "eye_mm needs an encoder of the web; give its "
                                      "count, um, or remove eye_mm"));
  if (head.has_eye_mm() && head.field_mm() > 0 && head.eye_mm() <= head.field_mm() / 2) {
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format(
             "scan_head.eye_mm: {:g} is not before the field, which begins {:g} mm "
             "before its middle; give the way from the eye to the middle of the "
             "field, beyond that",
             head.eye_mm(), head.field_mm() / 2),
         fmt::format("{:g}", head.eye_mm())});
  }
  if (errors.empty() && !head.correction_file().empty()) {
    if (const auto table = LoadCorrection(head); !table) errors.push_back(table.error());
  }
  return errors;
}

}  // namespace intaglio::drivers
