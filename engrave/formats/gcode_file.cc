#include "engrave/formats/gcode_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/atomic_file.h"

namespace intaglio::formats {
namespace {

/// A comment must not contain parentheses, because they do not nest in G-code.
std::string CommentLine(std::string comment) {
  std::replace(comment.begin(), comment.end(), '(', '[');
  std::replace(comment.begin(), comment.end(), ')', ']');
  return fmt::format("({})\n", comment);
}

/// With fixed decimals, and no minus before a zero.
void AppendBlock(char letter, double value, int decimals, std::string& line) {
  const std::size_t begin = line.size();
  line += fmt::format(" {}{:.{}f}", letter, value, decimals);
  if (line.find_first_of("123456789", begin) == std::string::npos) {
    line.erase(
        std::remove(line.begin() + static_cast<std::ptrdiff_t>(begin), line.end(), '-'),
        line.end());
  }
}

void RequireInRange(const GcodeOptions& options) {
  Require(options.decimals >= 0 && options.decimals <= 9, "{} decimals",
          options.decimals);
  Require(std::isfinite(options.feed_mm_min) && options.feed_mm_min >= 0,
          "a feed of {} mm/min", options.feed_mm_min);
  Require(!options.pulse.empty(), "no pulse command");
  Require(options.origin_mm.allFinite(), "the origin is not finite");
}

std::string Beginning(const PointTable& table, const GcodeOptions& options) {
  std::string text;
  for (const std::string& comment : table.comments) text += CommentLine(comment);
  if (!options.header.empty()) text += options.header + "\n";
  // The feed stays in force for all moves.
  if (options.feed_mm_min > 0) text += fmt::format("F{:.3f}\n", options.feed_mm_min);
  return text;
}

}  // namespace

Status WriteGcode(const std::filesystem::path& file, const PointTable& table,
                  const GcodeOptions& options) {
  RequireWritable(table);
  RequireInRange(options);
  io::AtomicFile out = INTAGLIO_TRY(io::AtomicFile::Create(file));
  INTAGLIO_TRY(out.Write(Beginning(table, options)));
  std::string text;
  for (const Vec3& p_mm : table.points_mm) {
    // All three coordinates in every line: a run can be resumed at any line.
    text = options.feed_mm_min > 0 ? "G1" : "G0";
    for (int axis = 0; axis < 3; ++axis) {
      AppendBlock(options.words[static_cast<std::size_t>(axis)],
                  p_mm[axis] - options.origin_mm[axis], options.decimals, text);
    }
    text += '\n';
    text += options.pulse;
    text += '\n';
    if (Status status = out.Write(text); !status) return status;
  }
  if (!options.footer.empty()) {
    if (Status status = out.Write(options.footer + "\n"); !status) return status;
  }
  return out.Commit();
}

}  // namespace intaglio::formats
