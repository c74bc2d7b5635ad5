#include "engrave/mesh/import/mesh_import.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "engrave/core/try.h"
#include "engrave/io/lower_case.h"
#include "engrave/mesh/files/collada_check.h"
#include "engrave/mesh/files/gltf_check.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/files/own_formats.h"
#include "engrave/mesh/import/library_import.h"

namespace intaglio::mesh {
namespace {

Status CheckCollada(const ImportSource& source, std::string_view text) {
  const std::string wrong = WrongInCollada(text);
  if (wrong.empty()) return {};
  return source.Refuse(
      ErrorCode::kUnreadable,
      fmt::format("it cannot be read as dae ({}); the file is damaged, export it again",
                  wrong));
}

/// The checks of a file's content before the library reads it.
Result<FileFindings> CheckContent(const ImportSource& source, std::string_view text) {
  if (source.extension == "dae") INTAGLIO_TRY(CheckCollada(source, text));
  if (source.extension == "gltf" || source.extension == "glb")
    return CheckGltf(source, text);
  return FileFindings();
}

}  // namespace

Result<ImportedMesh> ImportMeshFromMemory(std::span<const std::byte> bytes,
                                          std::string_view extension,
                                          const ImportOptions& options,
                                          std::string_view name) {
  ImportSource source{std::string(name), io::LowerCaseExtension(extension), options};
  if (HasOwnReader(source.extension))
    return ReadOwnFormat(bytes, extension, options, name);
  INTAGLIO_TRY(CheckSource(source, bytes.size()));
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::optional<std::string> aligned;
  if (source.extension == "glb") aligned = INTAGLIO_TRY(AlignedGlb(source, text));
  if (aligned) text = *aligned;
  auto findings = INTAGLIO_TRY(CheckContent(source, text));
  if (aligned)
    findings.Add({.what = "chunk whose size is no multiple of 4",
                  .where = "",
                  .remedy = "",
                  .count = 1,
                  .effect = Effect::kNothingSeen});
  constexpr double kMetre_mm = 1000;
  const auto unit_mm = source.extension == "dae" ? UnitInCollada_mm(text) : std::nullopt;
  // The library brings a DAE to metres by the unit that it declares.
  if (unit_mm) source.unit_mm = kMetre_mm;
  auto imported = ImportByLibrary(source, [&](Assimp::Importer& importer) {
    importer.ReadFileFromMemory(text.data(), text.size(), 0, source.extension.c_str());
  });
  if (imported) {
    for (const FileFinding& finding : findings) imported->findings.Add(finding);
    imported->declared_unit_mm = unit_mm.value_or(0);
  }
  return imported;
}

}  // namespace intaglio::mesh
