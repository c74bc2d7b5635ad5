#include "tests/services/drivers/bjjcz/bjjcz_rig.h"
#include "tests/services/drivers/bjjcz/point_rig.h"
#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {
namespace {

const RigRow<MotionRig> kBjjczMotion{"bjjcz", "bjjcz", &MakeBjjczMotionRig};
const RigRow<LaserRig> kBjjczLaserRow{"bjjcz", "bjjcz", &MakeBjjczLaserRig};
const RigRow<MarkRig> kBjjczMarks[] = {
    {"bjjcz", "bjjcz_fibre", &MakeBjjczMarkRig},
    {"bjjcz", "bjjcz_uv", &MakeBjjczMarkRig},
};

}  // namespace
}  // namespace intaglio::drivers
