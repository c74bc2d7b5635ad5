#pragma once

// Reads Excellon drill files, as layout programs write them for circuit boards.
//
// What is read: the header (M48 .. % or M95) with METRIC or INCH, LZ or TZ, digits as
// 000.000, and tools (T1C0.8); M71 M72; holes (X Y, modal), G90 G91 and ICI; R (a hole
// repeated); G85 (slots); routing with G00 G01 G02 G03 (radius A, or I J), M15 M16 M17;
// M30 M00 end the file. Comments, feeds and speeds have no meaning here; every other
// command is skipped and counted. Frame: the file's, y up.
//
// Coordinates without a point have their zeros left out: behind with LZ, in front with
// TZ, of 3.3 digits in mm and 2.4 in inches. A file that does not declare which is
// refused unless the options say so: a guess would be wrong by powers of ten.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/contour/drill_plan.h"
#include "engrave/contour/element.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

enum class Zeros {
  kLeading,   ///< those in front are written (LZ)
  kTrailing,  ///< those behind are written (TZ)
};

struct ExcellonOptions {
  std::optional<Zeros> zeros;     ///< of a file that declares none
  std::optional<double> unit_mm;  ///< of a file that declares none: 1 or 25.4
  std::uint64_t max_file_bytes = std::uint64_t{64} << 20;
  std::uint64_t max_holes = 1'000'000;  ///< and slots together
};

struct DrillFile {
  std::vector<Hole> holes;
  std::vector<Element> slots;  ///< tracks and arc tracks, as wide as their tool
  std::map<std::string, std::uint64_t> left_out;  ///< commands that are not read
};

/// Errors name the file, the line and the remedy: kUnreadable (no drill file, a line that
/// is none), kInvalidValue (numbers), kMissing (units, zeros, a tool), kUnsupported (an
/// arc that does not exist), kTooLarge (a limit).
Result<DrillFile> ReadExcellon(std::string_view text, std::string_view name,
                               const ExcellonOptions& options = {});

}  // namespace intaglio::contour
