#include "engrave/mesh/files/gltf_buffers.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::mesh {
namespace {

/// The place of the closing quote of the string that opens there; npos: none.
std::size_t EndOfString(std::string_view json, std::size_t open) {
  for (std::size_t at = open + 1; at < json.size(); ++at) {
    if (json[at] == '\\') {
      ++at;
    } else if (json[at] == '"') {
      return at;
    }
  }
  return json.npos;
}

bool IsKey(std::string_view json, std::size_t end_of_string) {
  const auto next = json.find_first_not_of(" \t\r\n", end_of_string + 1);
  return next != json.npos && json[next] == ':';
}

/// The path behind percent signs (RFC 3986) and "\/", the one escape that JSON needs
/// nowhere and programs write; none: another escape.
std::optional<std::string> Decoded(std::string_view uri) {
  std::string path;
  for (std::size_t at = 0; at < uri.size(); ++at) {
    if (uri.substr(at).starts_with("\\/")) continue;
    if (uri[at] != '%') {
      path += uri[at];
      continue;
    }
    unsigned value = 0;
    const std::string_view digits = uri.substr(at + 1, 2);
    const auto [end, failure] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    if (failure != std::errc() || digits.size() != 2 || end != digits.data() + 2)
      return std::nullopt;
    path += static_cast<char>(value);
    at += 2;
  }
  return path;
}

bool IsBelowTheFolder(std::string_view path) {
  if (path.empty() || path.starts_with('/') || path.ends_with('/')) return false;
  if (path.find_first_of(std::string_view("\\\0", 2)) != path.npos) return false;
  while (!path.empty()) {
    const std::string_view part = path.substr(0, path.find('/'));
    if (part == "..") return false;
    path.remove_prefix(std::min(path.size(), part.size() + 1));
  }
  return true;
}

Result<std::string> PathOf(std::string_view uri) {
  const auto path = Decoded(uri);
  // A colon divides a scheme from an address; in a name it is written as %3A.
  if (path && uri.find(':') == uri.npos && IsBelowTheFolder(*path)) return *path;
  return Fail(ErrorCode::kUnsupported,
              fmt::format("its buffer {:.80?} is no file in the folder of the model; put "
                          "the file beside the model, or export it as GLB",
                          uri),
              std::string(uri));
}

}  // namespace

Result<std::vector<GltfBufferFile>> BufferFilesOf(std::string_view json) {
  std::vector<GltfBufferFile> files;
  int depth = 0;
  bool in_buffers = false, is_uri = false;
  for (std::size_t at = 0; at < json.size(); ++at) {
    if (json[at] == '{' || json[at] == '[') ++depth;
    if (json[at] == '}' || json[at] == ']') --depth;
    if (json[at] == ',') is_uri = false;
    if (json[at] != '"') continue;
    const std::size_t end = EndOfString(json, at);
    if (end == json.npos) break;
    const std::string_view text = json.substr(at + 1, end - at - 1);
    if (IsKey(json, end)) {
      if (depth == 1) in_buffers = text == "buffers";
      is_uri = in_buffers && depth == 3 && text == "uri";
    } else if (is_uri && !text.starts_with("data:")) {
      files.push_back({INTAGLIO_TRY(PathOf(text)), at, end + 1});
    }
    at = end;
  }
  return files;
}

}  // namespace intaglio::mesh
