#pragma once

// The checksum of what a stage made, as its consumer would get it: two workers that make
// the same task have the same one, whatever their hosts, builds and numbers of threads.

#include <string>

#include "services/platform/host/stage/stage_task.h"

namespace intaglio::discretizer {

/// The count and a CRC-32 as text, "8192-0a1b2c3d". That of points is the CRC of x, y, z
/// (IEEE 754 binary64, mm) and source (uint32) of each in their order, little-endian.
/// That of marks is the same of their pens and then of each mark, the fields in the order
/// of idl/cloud.idl MarkBatch, with a number (uint32) before every text and every list;
/// `dark` of rows alone, behind their places.
std::string ChecksumOf(const host::StageResult& result);

}  // namespace intaglio::discretizer
