#pragma once

// Fills in what a job of marks left open, as documented in proto/mark.proto and
// proto/course.proto. Values that are given stay as they are, right or wrong.

#include "proto/job.pb.h"

namespace intaglio {

/// Every default of mark.proto but the number of repeats, which may follow from the
/// table; of an item's pen that of the job.
Marks WithDefaults(Marks marks);

/// Every default is a constant of course.proto, but the speed of plunging, which is that
/// at work, depth_mm, which a laser does not have, the height of tabs, half of it, and
/// the diameter of a V-bit, its width at that depth (v_bit.h).
Course WithDefaults(Course course);

/// Every default that such a job has.
JobSpec WithMarkDefaults(JobSpec job);

}  // namespace intaglio
