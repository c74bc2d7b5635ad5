#include "services/job/teach/stage_per_glass.h"

#include "engrave/core/try.h"
#include "materials_db/material_store.h"

namespace intaglio {

Result<double> StagePerGlassRatio(const std::string& database, const MachineSpec& machine,
                                  const MachineLens& lens, const std::string& glass) {
  const auto store = INTAGLIO_TRY(
      materials_db::MaterialStore::Open(materials_db::DatabasePathOf(database)));
  const auto material = store.Find(glass);
  if (!material)
    return Fail(material.error().code, "glass: " + material.error().message, glass);
  const auto values = INTAGLIO_TRY(materials_db::ComputeOptics(
      *material, machine.laser().wavelength_nm(), lens.numerical_aperture()));
  return values.stage_per_glass_ratio;
}

}  // namespace intaglio
