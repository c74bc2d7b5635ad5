#include "engrave/mesh/files/own_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/lower_case.h"
#include "engrave/mesh/files/obj_file.h"
#include "engrave/mesh/files/ply_check.h"
#include "engrave/mesh/files/ply_file.h"
#include "engrave/mesh/files/stl_file.h"
#include "engrave/mesh/files/three_mf_file.h"

namespace intaglio::mesh {
namespace {

Status CheckExtension(const ImportSource& source) {
  if (std::find(kMeshExtensions.begin(), kMeshExtensions.end(), source.extension) !=
      kMeshExtensions.end()) {
    return {};
  }
  return source.Refuse(
      ErrorCode::kUnsupported,
      fmt::format("models of the kind '{}' cannot be read; export it as one of {}",
                  source.extension, fmt::join(kMeshExtensions, ", ")));
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

Result<ImportedMesh> ReadStlText(std::string_view text, const ImportSource& source) {
  if (!source.options.objects.empty())
    return source.RefuseObject(source.options.objects.front(), {});
  MemoryReader reader(text);
  return ReadStl(reader, text.size(), source);
}

Result<ImportedMesh> ReadPlyText(std::string_view text, const ImportSource& source) {
  INTAGLIO_TRY(CheckPlyHeader(source, text, text.size()));
  return ReadPly(text, source);
}

struct OwnFormat {
  std::string_view extension;
  Result<ImportedMesh> (*read)(std::string_view text, const ImportSource& source);
};
constexpr std::array<OwnFormat, 4> kOwn = {{{"stl", &ReadStlText},
                                            {"obj", &ReadObj},
                                            {"ply", &ReadPlyText},
                                            {"3mf", &ReadThreeMf}}};

/// "stl, obj, ply, 3mf".
std::string OwnExtensions() {
  std::vector<std::string_view> names;
  for (const OwnFormat& format : kOwn) names.push_back(format.extension);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// nullptr: it has no reader here.
const OwnFormat* OwnFormatOf(std::string_view extension) {
  const auto found = std::ranges::find(kOwn, extension, &OwnFormat::extension);
  return found == kOwn.end() ? nullptr : &*found;
}

}  // namespace

bool HasOwnReader(std::string_view extension) {
  return OwnFormatOf(extension) != nullptr;
}

Status CheckSource(const ImportSource& source, std::size_t byte_count) {
  INTAGLIO_TRY(CheckExtension(source));
  return CheckSize(source, byte_count);
}

Result<ImportedMesh> ReadOwnFormat(std::span<const std::byte> bytes,
                                   std::string_view extension,
                                   const ImportOptions& options, std::string_view name) {
  const ImportSource source{std::string(name), io::LowerCaseExtension(extension),
                            options};
  INTAGLIO_TRY(CheckSource(source, bytes.size()));
  const OwnFormat* format = OwnFormatOf(source.extension);
  if (format == nullptr) {
    return source.Refuse(
        ErrorCode::kUnsupported,
        fmt::format("the format {} is read by the program intaglio-mesh-reader alone; "
                    "export it as one of {}",
                    source.extension, OwnExtensions()));
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  try {
    return format->read(text, source);
  } catch (const std::bad_alloc&) {
    return source.Refuse(ErrorCode::kTooLarge,
                         "not enough memory to read it; reduce the mesh");
  }
}

}  // namespace intaglio::mesh
