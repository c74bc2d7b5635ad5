#pragma once

// A packed plan of points that are in memory, and numbers of packed bytes, for tests.

#include <cstring>
#include <string>

#include "engrave/core/try.h"
#include "services/console/plan_packer.h"

namespace intaglio::console {

inline Result<std::string> PackPlan(const PointList& path_mm, const Vec3& block_mm) {
  PlanPacker packer = INTAGLIO_TRY(PlanPacker::Begin(path_mm.size(), block_mm));
  packer.Count(path_mm);
  INTAGLIO_TRY(packer.Place(path_mm));
  return packer.Finish();
}

template <typename Value>
Value At(const std::string& bytes, std::size_t offset) {
  Value value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace intaglio::console
