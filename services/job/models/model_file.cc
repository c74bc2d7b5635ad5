#include "services/job/models/model_file.h"

#include <fmt/format.h>

#include <span>
#include <string_view>

#include "engrave/core/try.h"
#include "engrave/io/lower_case.h"
#include "engrave/io/whole_file.h"
#include "engrave/mesh/files/gltf_buffers.h"
#include "services/platform/text_format/base64.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;

/// `text`, the glTF, with these files in the places of their uris.
Result<std::string> WithBuffers(const fs::path& file, std::string_view text,
                                const std::vector<mesh::GltfBufferFile>& buffers,
                                std::uint64_t max_bytes) {
  std::string whole;
  std::size_t done = 0;
  for (const mesh::GltfBufferFile& buffer : buffers) {
    const auto bytes = io::ReadWholeFile(file.parent_path() / buffer.path, max_bytes);
    if (!bytes) return tl::unexpected(bytes.error());
    whole.append(text.substr(done, buffer.begin - done));
    whole.append("\"data:application/octet-stream;base64,");
    whole.append(Base64Of(std::as_bytes(std::span(*bytes))) + "\"");
    done = buffer.end;
    if (whole.size() > max_bytes) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("with its buffers it has more than the {} bytes allowed; "
                              "reduce the mesh or raise the limit",
                              max_bytes));
    }
  }
  return whole.append(text.substr(done));
}

}  // namespace

bool HasOtherFiles(const fs::path& file) {
  return io::LowerCaseExtension(file.extension().string()) == "gltf";
}

Result<std::string> ReadModelFile(const fs::path& file, std::uint64_t max_bytes) {
  auto text = INTAGLIO_TRY(io::ReadWholeFile(file, max_bytes));
  if (!HasOtherFiles(file)) return text;
  const auto buffers = mesh::BufferFilesOf(text);
  if (!buffers) return tl::unexpected(io::AboutFile(buffers.error(), file));
  if (buffers->empty()) return text;
  auto whole = WithBuffers(file, text, *buffers, max_bytes);
  if (!whole) return tl::unexpected(io::AboutFile(whole.error(), file));
  return whole;
}

}  // namespace intaglio
