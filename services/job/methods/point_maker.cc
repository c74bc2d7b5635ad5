#include "services/job/methods/point_maker.h"

#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio {
namespace {

std::vector<PointMaker> MakeTable() {
  std::vector<PointMaker> table = MeshMakers();
  for (auto part : {DrawingMakers(), PictureMakers()}) {
    table.insert(table.end(), part.begin(), part.end());
  }
  return table;
}

}  // namespace

const PointMaker& MakerOf(const Method& method) {
  static const std::vector<PointMaker> kTable = MakeTable();
  const auto found = std::find_if(
      kTable.begin(), kTable.end(),
      [&](const PointMaker& maker) { return maker.method_number == method.number; });
  Require(found != kTable.end(), "the method {} has no maker", method.name());
  return *found;
}

}  // namespace intaglio
