// Any bytes as a glass catalog: every glass that comes out is sound, every mistake has a
// message, and an export of the glasses reads back as equal.

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "materials_db/export_rii.h"
#include "materials_db/import_agf.h"
#include "materials_db/import_rii.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::materials_db;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const Imported imported = ImportAgf(text, "CATALOG");
  if (imported.errors.size() > kMaxAgfErrors + 16) std::abort();
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
