#include "engrave/formats/point_file_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <system_error>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/lower_case.h"
#include "engrave/io/whole_file.h"

namespace intaglio::formats {
namespace {

using Parser = Result<PointTable> (*)(std::string_view, const PointFileLimits&);
using Writer = Status (*)(const std::filesystem::path&, const PointTable&);

struct Kind {
  std::string_view extension;
  Parser parse;
  Writer write;
};

constexpr std::array<Kind, 6> kKinds = {{{"ply", ParsePly, WritePly},
                                         {"xyz", ParseXyz, WriteXyz},
                                         {"txt", ParseXyz, WriteXyz},
                                         {"cft", ParseCft, WriteCft},
                                         {"scl", ParseScl, WriteScl},
                                         {"dxf", ParseDxf, WriteDxf}}};

const Kind* KindOf(std::string_view extension) {
  const auto* found = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& kind) {
    return kind.extension == extension;
  });
  return found == kKinds.end() ? nullptr : found;
}

Result<Parser> ParserOf(std::string_view extension) {
  const std::string lower = io::LowerCaseExtension(extension);
  const Kind* kind = KindOf(lower);
  if (kind != nullptr) return kind->parse;
  return Fail(ErrorCode::kUnsupported,
              fmt::format("points of the kind '{}' are not known; give one of {}", lower,
                          PointExtensions()),
              lower);
}

/// Formats allow a file without points; nobody who asks for points can use it.
Result<PointTable> WithPoints(Result<PointTable> table) {
  if (!table || !table->points_mm.empty()) return table;
  return Fail(ErrorCode::kMissing,
              "it has no points; name a file with one point or more");
}

}  // namespace

std::string PointExtensions() {
  std::string list;
  for (const Kind& kind : kKinds) {
    list += fmt::format("{}{}", list.empty() ? "" : ", ", kind.extension);
  }
  return list;
}

Result<PointTable> ReadPoints(const std::filesystem::path& file,
                              const PointFileLimits& limits) {
  const Result<Parser> parser = ParserOf(file.extension().string());
  if (!parser) return tl::unexpected(io::AboutFile(parser.error(), file));
  auto table = INTAGLIO_TRY(ReadAndParse(file, limits, *parser));
  auto checked = WithPoints(std::move(table));
  if (!checked) return tl::unexpected(io::AboutFile(checked.error(), file));
  return checked;
}

Result<PointTable> ParsePoints(std::string_view bytes, std::string_view extension,
                               const PointFileLimits& limits) {
  const Parser parser = INTAGLIO_TRY(ParserOf(extension));
  return WithPoints(parser(bytes, limits));
}

Status WritePoints(const std::filesystem::path& file, const PointTable& table) {
  const std::string extension = io::LowerCaseExtension(file.extension().string());
  if (const Kind* kind = KindOf(extension)) return kind->write(file, table);
  std::error_code unknown;
  const auto status = std::filesystem::status(file, unknown);
  const bool is_device = std::filesystem::exists(status) &&
                         !std::filesystem::is_regular_file(status) &&
                         !std::filesystem::is_directory(status);
  if (extension.empty() && is_device) return WriteXyz(file, table);
  return Fail(ErrorCode::kUnsupported,
              fmt::format("{}: points of the kind '{}' are not known; name a file that "
                          "ends in one of {}",
                          file.string(), extension, PointExtensions()),
              extension);
}

}  // namespace intaglio::formats
