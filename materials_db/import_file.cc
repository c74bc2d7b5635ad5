#include "materials_db/import_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "engrave/io/lower_case.h"
#include "engrave/io/whole_file.h"
#include "materials_db/import_agf.h"
#include "materials_db/import_rii.h"

namespace intaglio::materials_db {

Imported ImportFile(const std::filesystem::path& file) {
  const std::string ending = io::LowerCaseExtension(file.extension().string());
  const bool is_agf = ending == "agf";
  Imported imported;
  if (!is_agf && ending != "yml" && ending != "yaml") {
    imported.errors.push_back(
        {ErrorCode::kUnsupported,
         fmt::format("{}: name a glass catalog (.agf) or a refractiveindex.info record "
                     "(.yml)",
                     file.string()),
         file.string()});
    return imported;
  }
  const auto bytes = io::ReadWholeFile(file, is_agf ? kMaxAgfBytes : kMaxRiiBytes);
  if (!bytes) {
    imported.errors.push_back(bytes.error());
    return imported;
  }
  const std::string name = file.stem().string();
  imported = is_agf ? ImportAgf(*bytes, name) : ImportRii(*bytes, name);
  for (Error& error : imported.errors) {
    error.message = fmt::format("{}: {}", file.string(), error.message);
  }
  return imported;
}

}  // namespace intaglio::materials_db
