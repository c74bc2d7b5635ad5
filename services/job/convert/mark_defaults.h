#pragma once

// Fills in what a job of marks left open, as documented in proto/mark.proto and
// proto/course.proto. Values that are given stay as they are, right or wrong.

#include "proto/job.pb.h"

namespace intaglio {

/// Every default of mark.proto but the number of repeats, which may follow from the
/// table; of an item's pen that of the job.
Marks WithDefaults(Marks marks);

/// Every default but the speed of plunging, which is that at work, and depth_mm, which a
/// laser does not have, with the height of tabs, half of it, is a constant of
/// course.proto.
Course WithDefaults(Course course);

/// Every default that such a job has.
JobSpec WithMarkDefaults(JobSpec job);

}  // namespace intaglio
