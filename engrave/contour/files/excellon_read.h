#pragma once

// Reads Excellon drill files, as layout programs write them for circuit boards.
//
// What is read: the header (M48 .. % or M95) with METRIC or INCH, LZ or TZ, digits as
// 000.000 or in the comment ;FILE_FORMAT=4:4, and tools (T1C0.8); M71 M72; holes (X Y,
// modal), G90 G91 and ICI; R (a hole repeated); patterns (M25 .. M01, repeated by M02
// until M08); G85 (slots); routing with G00 G01 G02 G03 (radius A, or I J), M15 M16 M17;
// M30 M00 end the file. Other comments, feeds, speeds and stops have no meaning here.
// What would move holes and is not obeyed is refused with its line: a zero set elsewhere
// (G92 G93), canned cycles (G82 G83 G84 G87 ..), mirrored images and exchanged axes (M70
// M80 M90). Every other command is skipped and counted. Frame: the file's, y up.
//
// Coordinates without a point have their zeros left out: behind with LZ, in front with
// TZ, of 3.3 digits in mm and 2.4 in inches. In a file that does not declare which, a
// number with all its digits is read; another is refused unless the options say so: a
// guess would be wrong by powers of ten.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/contour/drill_plan.h"
#include "engrave/contour/element.h"
#include "engrave/core/findings.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

struct ExcellonOptions {
  /// The line of units that a file lacks, as it would be in its header: METRIC or INCH,
  /// then LZ, TZ or digits, e.g. "INCH,TZ,00.0000". What the file declares goes first.
  std::string units;
  /// `units` goes first, of a file that declares what is wrong; what it has no field for
  /// (zeros, digits) is the file's. What differs is a finding that names both.
  bool replace_units = false;
  std::uint64_t max_file_bytes = std::uint64_t{64} << 20;
  std::uint64_t max_holes = 1'000'000;  ///< and slots together
};

struct DrillFile {
  std::vector<Hole> holes;
  std::vector<Element> slots;  ///< tracks and arc tracks, as wide as their tool
  FileFindings findings;       ///< commands that are skipped, units that are replaced
};

/// Errors name the file, the line and the remedy: kUnreadable (no drill file, a line that
/// is none), kInvalidValue (numbers), kMissing (units, zeros, a tool), kUnsupported (see
/// above, an arc that does not exist), kTooLarge (a limit).
Result<DrillFile> ReadExcellon(std::string_view text, std::string_view name,
                               const ExcellonOptions& options = {});

}  // namespace intaglio::contour
