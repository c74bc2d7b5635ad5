#include "services/job/models/reading_process.h"

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/mesh/files/own_formats.h"
#include "services/job/models/mesh_answer.h"
#include "services/job/reading/file_process.h"

namespace intaglio::mesh_reader {
namespace {

using mesh::ImportOptions;

constexpr std::size_t kBytesPerSecond = 4'000'000;

/// Twice what the largest meshes take (mesh_formats.h), and the libraries.
std::uint64_t MemoryBytes(const ImportOptions& options) {
  constexpr std::uint64_t kLibraries = std::uint64_t{1} << 30, kBytesPerTriangle = 500;
  return kLibraries + kBytesPerTriangle * options.max_triangles;
}

Answer Read(const ReadingProcess& reader, std::span<const std::byte> bytes,
            std::string_view extension, const ImportOptions& options,
            std::string_view name) {
  const auto refuse = [&](ErrorCode code, const std::string& why) {
    return Fail(code, fmt::format("{}: {}", name, why), std::string(name));
  };
  reading::FileProcess process;
  process.time = reader.time + std::chrono::seconds(bytes.size() / kBytesPerSecond);
  process.memory_bytes = MemoryBytes(options);
  process.words = {reader.program.string(),
                   "--",
                   std::string(extension),
                   std::string(name),
                   std::to_string(options.max_file_bytes),
                   std::to_string(options.max_unpacked_ratio),
                   std::to_string(options.max_triangles)};
  process.words.insert(process.words.end(), options.objects.begin(),
                       options.objects.end());
  const auto end = INTAGLIO_TRY(reading::RunOnFile(process, bytes, name));
  if (end.is_too_long) {
    return refuse(ErrorCode::kTooLarge,
                  fmt::format("reading it took more than {} s of processor time; reduce "
                              "the mesh, or export it as stl",
                              process.time.count()));
  }
  if (end.exit_code == 0) {
    if (auto answer = ParseAnswer(end.output)) return *std::move(answer);
  }
  return refuse(ErrorCode::kUnreadable,
                fmt::format("it crashed the reader of {} files ({}); the file is "
                            "damaged, export it again, preferably as stl",
                            extension, end.reason));
}

}  // namespace

mesh::MeshReader ReadBy(const ReadingProcess& process) {
  return [process](std::span<const std::byte> bytes, std::string_view extension,
                   const ImportOptions& options, std::string_view name) {
    return mesh::IsReadByProcess(extension)
               ? Read(process, bytes, extension, options, name)
               : mesh::ReadOwnFormat(bytes, extension, options, name);
  };
}

}  // namespace intaglio::mesh_reader
