#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

Status MarkDriver::Hold() {
  return Fail(ErrorCode::kUnsupported,
              "this controller cannot rest within a mark: stop the run");
}

}  // namespace intaglio::drivers
