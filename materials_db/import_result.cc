#include "materials_db/import_result.h"

#include <cmath>

namespace intaglio::materials_db {

bool AgreesWithIndex(const optics::Dispersion& dispersion, double nd) {
  constexpr double kFraunhoferDNm = 587.5618;
  if (!(nd > 1)) return true;
  const auto index = optics::RefractiveIndex(dispersion, kFraunhoferDNm);
  return !index || std::abs(*index - nd) <= kIndexTolerance;
}

}  // namespace intaglio::materials_db
