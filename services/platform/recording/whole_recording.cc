#include "services/platform/recording/whole_recording.h"

#include <fmt/format.h>

#include "engrave/core/try.h"

namespace intaglio::recording {
namespace {

namespace fs = std::filesystem;

Status Fill(const fs::path& file, const std::string& library,
            const std::function<Status(McapWriter&)>& fill) {
  auto writer = INTAGLIO_TRY(McapWriter::Create(file, {.library = library}));
  INTAGLIO_TRY(fill(writer));
  return writer.Close();
}

}  // namespace

Status WriteWhole(const std::vector<std::string>& sources, const fs::path& target,
                  const std::string& library,
                  const std::function<Status(McapWriter&)>& fill) {
  std::error_code error;
  const fs::path temporary = target.string() + ".part";
  for (const std::string& source : sources) {
    // What a killed program left behind may be a source, too.
    for (const fs::path& written : {target, temporary}) {
      if (!fs::equivalent(source, written, error)) continue;
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("{} is an input and cannot be overwritten; give another file",
                      written.string()),
          written.string());
    }
  }
  if (auto filled = Fill(temporary, library, fill); !filled) {
    fs::remove(temporary, error);
    return filled;
  }
  fs::rename(temporary, target, error);
  if (error) {
    return Fail(
        ErrorCode::kIo,
        fmt::format("cannot give {} its name: {}", target.string(), error.message()),
        target.string());
  }
  return {};
}

}  // namespace intaglio::recording
