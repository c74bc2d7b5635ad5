#include "services/platform/command_line/supplied_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "engrave/io/nearest_name.h"
#include "services/platform/command_line/other_programs.h"

namespace intaglio::command_line {
namespace {

namespace fs = std::filesystem;
constexpr std::array kExtensions = {".textproto", ".json", ".post"};

}  // namespace

fs::path SuppliedFolder() {
  const char* named = std::getenv(kSuppliedVariable);
  if (named != nullptr && *named != '\0') return named;
  return ProgramFolder().parent_path() / "share" / "intaglio";
}

std::vector<std::string> SuppliedNames(const SuppliedKind& kind) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry :
       fs::directory_iterator(SuppliedFolder() / kind.folder, error)) {
    const fs::path file = entry.path().filename();
    if (std::ranges::find(kExtensions, file.extension().string()) != kExtensions.end())
      names.push_back(file.stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

Result<fs::path> FindSupplied(const std::string& name_or_file, const SuppliedKind& kind) {
  std::error_code error;
  if (fs::exists(name_or_file, error))
    return fs::absolute(name_or_file).lexically_normal();
  const fs::path folder = SuppliedFolder() / kind.folder;
  for (const char* extension : kExtensions) {
    const fs::path supplied = folder / (name_or_file + extension);
    if (fs::exists(supplied, error)) return fs::canonical(supplied);
  }
  const auto names = SuppliedNames(kind);
  const auto near = io::NearestName(name_or_file, names);
  const std::string known =
      names.empty()
          ? fmt::format(
                "there is no supplied {0} in {1}; install Intaglio again, or set "
                "{2} to the folder that has {3}/",
                kind.name, folder.string(), kSuppliedVariable, kind.folder)
          : fmt::format("supplied {}s: {}", kind.name, fmt::join(names, ", "));
  return Fail(
      ErrorCode::kNotFound,
      fmt::format("'{}' is neither a file nor a supplied {}{}; {}", name_or_file,
                  kind.name, near ? fmt::format("; did you mean {}?", *near) : "", known),
      name_or_file);
}

}  // namespace intaglio::command_line
