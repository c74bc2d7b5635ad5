#include "engrave/mesh/mesh_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/lower_case.h"
#include "engrave/mesh/collada_check.h"
#include "engrave/mesh/files/gltf_check.h"
#include "engrave/mesh/files/obj_file.h"
#include "engrave/mesh/files/ply_file.h"
#include "engrave/mesh/files/three_mf_file.h"
#include "engrave/mesh/import_source.h"
#include "engrave/mesh/library_import.h"
#include "engrave/mesh/ply_check.h"
#include "engrave/mesh/stl_file.h"

namespace intaglio::mesh {
namespace {

constexpr std::array<std::string_view, 8> kExtensions = {"stl",  "obj", "ply", "3mf",
                                                         "gltf", "glb", "dae", "3ds"};

Status CheckExtension(const ImportSource& source) {
  if (std::find(kExtensions.begin(), kExtensions.end(), source.extension) !=
      kExtensions.end()) {
    return {};
  }
  return source.Refuse(
      ErrorCode::kUnsupported,
      fmt::format("models of the kind '{}' cannot be read; export it as one of {}",
                  source.extension, fmt::join(kExtensions, ", ")));
}

Status CheckSize(const ImportSource& source, std::uint64_t byte_count) {
  if (byte_count == 0) {
    return source.Refuse(ErrorCode::kUnreadable, "the file is empty; export it again");
  }
  if (byte_count > source.options.max_file_bytes) {
    return source.Refuse(
        ErrorCode::kTooLarge,
        fmt::format("the file has {} bytes, more than the {} allowed; reduce the mesh or "
                    "raise the limit",
                    byte_count, source.options.max_file_bytes));
  }
  return {};
}

Status CheckCollada(const ImportSource& source, std::string_view text) {
  const std::string wrong = WrongInCollada(text);
  if (wrong.empty()) return {};
  return source.Refuse(
      ErrorCode::kUnreadable,
      fmt::format("it cannot be read as dae ({}); the file is damaged, export it again",
                  wrong));
}

/// The checks of a file's content before the library reads it.
Result<FileFindings> CheckContent(const ImportSource& source, std::string_view text,
                                  std::uint64_t byte_count) {
  if (source.extension == "ply") INTAGLIO_TRY(CheckPlyHeader(source, text, byte_count));
  if (source.extension == "dae") INTAGLIO_TRY(CheckCollada(source, text));
  if (source.extension == "gltf" || source.extension == "glb")
    return CheckGltf(source, text);
  return FileFindings();
}

/// What `read` gives, or the error that there is not enough memory for it.
template <typename Read>
Result<ImportedMesh> WithinMemory(const ImportSource& source, Read read) {
  try {
    return read();
  } catch (const std::bad_alloc&) {
    return source.Refuse(ErrorCode::kTooLarge,
                         "not enough memory to read it; reduce the mesh");
  }
}

}  // namespace

bool IsReadByLibrary(std::string_view extension) {
  const std::string lower = io::LowerCaseExtension(extension);
  return lower != "stl" &&
         std::find(kExtensions.begin(), kExtensions.end(), lower) != kExtensions.end();
}

bool MayDeclareUnit(std::string_view extension) {
  const std::string lower = io::LowerCaseExtension(extension);
  return lower == "dae" || lower == "3mf";
}

Result<ImportedMesh> ImportMeshFromMemory(std::span<const std::byte> bytes,
                                          std::string_view extension,
                                          const ImportOptions& options,
                                          std::string_view name) {
  ImportSource source{std::string(name), io::LowerCaseExtension(extension), options};
  INTAGLIO_TRY(CheckExtension(source));
  INTAGLIO_TRY(CheckSize(source, bytes.size()));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (source.extension == "stl") {
    if (!options.objects.empty()) return source.RefuseObject(options.objects.front(), {});
    MemoryReader reader(text);
    return WithinMemory(source, [&] { return ReadStl(reader, text.size(), source); });
  }
  if (source.extension == "obj")
    return WithinMemory(source, [&] { return ReadObj(text, source); });
  if (source.extension == "3mf")
    return WithinMemory(source, [&] { return ReadThreeMf(text, source); });
  auto findings = INTAGLIO_TRY(CheckContent(source, text, text.size()));
  if (source.extension == "ply")
    return WithinMemory(source, [&] { return ReadPly(text, source); });
  constexpr double kMetre_mm = 1000;
  const auto unit_mm = source.extension == "dae" ? UnitInCollada_mm(text) : std::nullopt;
  // The library brings a DAE to metres by the unit that it declares.
  if (unit_mm) source.unit_mm = kMetre_mm;
  auto imported = ImportByLibrary(source, [&](Assimp::Importer& importer) {
    importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, source.extension.c_str());
  });
  if (imported) {
    for (const FileFinding& finding : findings) imported->findings.Add(finding);
    imported->declared_unit_mm = unit_mm.value_or(0);
  }
  return imported;
}

}  // namespace intaglio::mesh
