#include "engrave/mesh/files/gltf_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "engrave/mesh/files/gltf_buffers.h"

namespace intaglio::mesh {
namespace {

/// What is between the brackets of the arrays behind the key, wherever it is, up to the
/// first closing one.
std::vector<std::string_view> ArraysOf(std::string_view json, std::string_view key) {
  std::vector<std::string_view> arrays;
  for (auto at = json.find(key); at != json.npos; at = json.find(key, at + 1)) {
    const std::string_view rest = json.substr(at + key.size());
    const auto open = rest.find_first_not_of(" \t\r\n:");
    if (open == rest.npos || rest[open] != '[') continue;
    arrays.push_back(rest.substr(open + 1, rest.find(']', open) - open - 1));
  }
  return arrays;
}

/// Whether a mesh or a node gives a weight that is not 0 to a target.
bool HasWeights(std::string_view json) {
  for (const std::string_view array : ArraysOf(json, "\"weights\"")) {
    if (array.find_first_of("123456789") != array.npos) return true;
  }
  return false;
}

/// The strings of the array behind the key, wherever it is; without escapes, which names
/// of extensions do not have.
std::vector<std::string_view> StringsOf(std::string_view json, std::string_view key) {
  std::vector<std::string_view> strings;
  for (std::string_view rest : ArraysOf(json, key)) {
    while (true) {
      const auto begin = rest.find('"');
      const auto end = begin == rest.npos ? rest.npos : rest.find('"', begin + 1);
      if (end == rest.npos) break;
      strings.push_back(rest.substr(begin + 1, end - begin - 1));
      rest.remove_prefix(end + 1);
    }
  }
  return strings;
}

/// They change the appearance alone: materials, textures, lights, what programs note for
/// themselves.
bool IsOfAppearance(std::string_view extension) {
  constexpr std::string_view kBeginnings[] = {"KHR_materials_",
                                              "KHR_texture_",
                                              "EXT_texture_",
                                              "MSFT_texture_",
                                              "KHR_lights_",
                                              "EXT_lights_",
                                              "KHR_xmp",
                                              "EXT_materials_",
                                              "ADOBE_materials_",
                                              "KHR_techniques_webgl",
                                              "AGI_",
                                              "KHR_animation_pointer"};
  return std::ranges::any_of(kBeginnings, [&](std::string_view beginning) {
    return extension.starts_with(beginning);
  });
}

// A GLB begins with its mark, version and size; a chunk with its size and kind.
constexpr std::size_t kGlbHead = 12;
constexpr std::size_t kChunkHead = 8;
constexpr std::size_t kAlignment = 4;

std::uint32_t NumberAt(std::string_view file, std::size_t at) {
  std::uint32_t number = 0;
  std::copy_n(file.data() + at, sizeof number, reinterpret_cast<char*>(&number));
  return number;
}

/// The size of the first chunk of a GLB; nullopt: it is none.
std::optional<std::uint32_t> FirstChunkOf(std::string_view file) {
  if (!file.starts_with("glTF") || file.size() < kGlbHead + kChunkHead)
    return std::nullopt;
  return NumberAt(file, kGlbHead);
}

/// Whether the chunk of points begins there, or the file ends.
bool GoesOnAt(std::string_view file, std::size_t at) {
  if (at > file.size()) return false;
  if (file.size() - at < kAlignment) return true;
  return file.size() - at >= kChunkHead &&
         file.substr(at + 4, 4) == std::string_view("BIN\0", 4) &&
         NumberAt(file, at) <= file.size() - at - kChunkHead;
}

void PutNumber(std::uint32_t number, std::size_t at, std::string& file) {
  std::copy_n(reinterpret_cast<const char*>(&number), sizeof number, file.data() + at);
}

/// The JSON of a GLB is its first chunk.
std::string_view JsonOf(std::string_view file) {
  const auto size = FirstChunkOf(file);
  return size ? file.substr(20, *size) : file;
}

}  // namespace

Result<FileFindings> CheckGltf(const ImportSource& source, std::string_view file) {
  // The library takes as much memory as a chunk declares.
  if (const auto size = FirstChunkOf(file)) {
    const std::size_t rest = file.size() - kGlbHead - kChunkHead;
    if (*size > rest)
      return source.RefuseAsUnreadable(
          fmt::format("its first chunk has {} bytes, and the file {}", *size, rest));
    const std::size_t next = kGlbHead + kChunkHead + *size;
    if (rest - *size >= kChunkHead && NumberAt(file, next) > rest)
      return source.RefuseAsUnreadable(fmt::format(
          "its second chunk has {} bytes, and the file {}", NumberAt(file, next), rest));
  }
  const std::string_view json = JsonOf(file);
  auto changing = StringsOf(json, "\"extensionsRequired\"");
  std::erase_if(changing, IsOfAppearance);
  // An instance is part of the shape also where a file does not require it.
  for (const std::string_view used : StringsOf(json, "\"extensionsUsed\"")) {
    if (used == "EXT_mesh_gpu_instancing") changing.push_back(used);
  }
  if (!changing.empty()) {
    return source.Refuse(
        ErrorCode::kUnsupported,
        fmt::format("it needs the extension {:.80} of glTF, which is not supported; "
                    "export it without this extension, or as stl",
                    changing.front()));
  }
  const auto files = BufferFilesOf(json);
  if (!files) return source.Refuse(files.error().code, files.error().message);
  if (!files->empty()) {
    return source.Refuse(
        ErrorCode::kUnreadable,
        fmt::format("its buffer {:.80?} is a file of its own, which does not come along "
                    "with it; export it as GLB",
                    files->front().path));
  }
  FileFindings findings;
  const auto used = StringsOf(json, "\"extensionsUsed\"");
  if (std::ranges::find(used, "KHR_node_visibility") != used.end()) {
    findings.Add({.what = "visibility of nodes (KHR_node_visibility)",
                  .where = "",
                  .remedy = "remove the nodes that are not seen, and export it again",
                  .count = 1,
                  .effect = Effect::kChanged});
  }
  if (HasWeights(json)) {
    findings.Add({.what = "morph target with a weight",
                  .where = "",
                  .remedy = "apply the shape keys and export it again",
                  .count = 1,
                  .effect = Effect::kChanged,
                  .plural = "morph targets with a weight"});
  } else if (!ArraysOf(json, "\"targets\"").empty()) {
    findings.Add({.what = "morph target without a weight",
                  .where = "",
                  .remedy = "",
                  .count = 1,
                  .effect = Effect::kNothingSeen,
                  .plural = "morph targets without a weight"});
  }
  return findings;
}

Result<std::optional<std::string>> AlignedGlb(const ImportSource& source,
                                              std::string_view file) {
  const auto size = FirstChunkOf(file);
  if (!size || *size % kAlignment == 0) return std::nullopt;
  const std::size_t end = kGlbHead + kChunkHead + *size;
  const std::size_t blanks = kAlignment - *size % kAlignment;
  const bool behind = GoesOnAt(file, end), rounded = GoesOnAt(file, end + blanks);
  // A rest below the alignment is padding, wherever it is taken to end.
  const bool ends = behind && file.size() - end < kAlignment;
  if (behind == rounded && !ends) {
    return source.Refuse(
        ErrorCode::kUnreadable,
        fmt::format(
            "its first chunk has {} bytes, which is no multiple of 4, and no chunk of "
            "points is found behind it (glTF 2.0, 4.4.3); export it with a newer "
            "program, or as .gltf or .stl",
            *size));
  }
  std::string aligned(file.substr(0, end));
  aligned.append(blanks, ' ');
  if (!ends) aligned += file.substr(behind ? end : end + blanks);
  PutNumber(static_cast<std::uint32_t>(aligned.size()), 8, aligned);
  PutNumber(static_cast<std::uint32_t>(*size + blanks), kGlbHead, aligned);
  return aligned;
}

}  // namespace intaglio::mesh
