#include "services/cli/job/job_glass.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "services/job/files/freeze.h"
#include "services/platform/host/version/software_version.h"

namespace intaglio::cli {

namespace fs = std::filesystem;

Result<materials_db::Material> FindGlass(JobAndMachine& job,
                                         const materials_db::MaterialStore& store) {
  const std::string asked = job.job.glass();
  auto material = store.Find(asked);
  if (!material) {
    return Fail(material.error().code, "glass: " + material.error().message, asked);
  }
  if (material->name != asked) {
    job.notes.push_back(
        fmt::format("glass {}: is {} in the material base", asked, material->name));
    job.job.set_glass(material->name);
  }
  return material;
}

Result<materials_db::Material> FindGlass(JobAndMachine& job,
                                         const std::string& materials_db) {
  const auto store = INTAGLIO_TRY(
      materials_db::MaterialStore::Open(materials_db::DatabasePathOf(materials_db)));
  return FindGlass(job, store);
}

Result<materials_db::OpticalValues> FindOptics(JobAndMachine& job,
                                               const std::string& materials_db) {
  const auto material = INTAGLIO_TRY(FindGlass(job, materials_db));
  return materials_db::ComputeOptics(material, job.job.laser().wavelength_nm(),
                                     job.job.lens().numerical_aperture());
}

Result<FrozenJob> FreezeWithGlass(JobAndMachine& job, const std::string& materials_db) {
  const auto material = INTAGLIO_TRY(FindGlass(job, materials_db));
  return FreezeJob(job.job, job.machine, material, {"", 0, "", host::SoftwareVersion()});
}

}  // namespace intaglio::cli
