#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

Status MarkDriver::Hold() {
  return Fail(ErrorCode::kUnsupported,
              "this controller cannot rest within a mark: stop the run");
}

Status MarkDriver::UseEye(const std::optional<PrintEye>& eye) {
  if (!eye) return {};
  return Fail(ErrorCode::kUnsupported,
              "marks.web.eye: the machine has no photo eye; remove it, or name the "
              "profile of a scan head with scan_head.eye_mm");
}

}  // namespace intaglio::drivers
