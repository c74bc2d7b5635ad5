// Any bytes as a record of refractiveindex.info: refused with a message, or glasses that
// are sound and that read back as equal once they are exported.

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "materials_db/export_rii.h"
#include "materials_db/import_rii.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::materials_db;
  const std::string_view yaml(reinterpret_cast<const char*>(bytes), size);
  const Imported imported = ImportRii(yaml, "glass");
  for (const auto& error : imported.errors) {
    if (error.message.empty()) std::abort();
  }
  if (imported.materials.empty() && imported.errors.empty()) std::abort();
  for (const Material& material : imported.materials) {
    if (!CheckMaterial(material).empty()) std::abort();
  }
  if (imported.materials.empty()) return 0;
  const Imported again = ImportRii(ExportRii(imported.materials), "other");
  if (!again.errors.empty() || again.materials != imported.materials) std::abort();
  return 0;
}
