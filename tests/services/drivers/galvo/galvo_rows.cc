#include "tests/services/drivers/galvo/head_rig.h"
#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {
namespace {

const RigRow<MarkRig> kScanHead{"scan-head", "scan_head", &MakeHeadMarkRig};

}  // namespace
}  // namespace intaglio::drivers
