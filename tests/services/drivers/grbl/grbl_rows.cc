#include "tests/services/drivers/grbl/course_mark_rig.h"
#include "tests/services/drivers/grbl/grbl_rig.h"
#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {
namespace {

const RigRow<MotionRig> kGrblMotion{"grbl", "grbl", &MakeGrblMotionRig};
const RigRow<LaserRig> kGrblLaser{"grbl", "grbl", &MakeGrblLaserRig};
const RigRow<MarkRig> kGrblCourses[] = {
    {"grbl-course", "grbl_laser", &MakeCourseMarkRig},
    {"grbl-course", "grbl_mill", &MakeCourseMarkRig},
    {"grbl-course", "grbl_mill_that_homes", &MakeCourseMarkRig},
};

}  // namespace
}  // namespace intaglio::drivers
