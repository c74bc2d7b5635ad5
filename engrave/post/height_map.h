#pragma once

// The heights of a surface that was probed at the places of a grid, so that a tool
// follows a sheet that does not lie flat: copper of 35 um on a board that is bent by 200
// um is cut evenly, or not at all, by a tool at one depth. Frame: that of the program
// (after its origin), mm; z is 0 where the tool's zero was set.

#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/post/tool_path.h"

namespace intaglio::post {

class HeightMap {
 public:
  /// `x_mm` and `y_mm` ascend, two or more each; `z_mm`: all of the first y, then of the
  /// next.
  HeightMap(std::vector<double> x_mm, std::vector<double> y_mm, std::vector<double> z_mm);

  /// Bilinear between the places; beyond them, as on their border.
  double At(const Vec2& place_mm) const;
  double max_mm() const { return max_mm_; }
  double min_mm() const { return min_mm_; }
  const std::vector<double>& x_mm() const { return x_mm_; }
  const std::vector<double>& y_mm() const { return y_mm_; }

  /// The moves of `lines`, all of them lines, divided so that the height along each is
  /// within `tolerance_mm` of that on a straight way between its ends. The map's frame
  /// begins at `origin_mm` of the path's.
  ToolPath Divided(const ToolPath& lines, const Vec2& origin_mm,
                   double tolerance_mm) const;
  /// kInvalidValue: a place of `path` is farther than half a step of the grid outside the
  /// probed places.
  Status RequireCovers(const ToolPath& path, const Vec2& origin_mm) const;

 private:
  std::vector<double> x_mm_, y_mm_, z_mm_;
  double min_mm_ = 0, max_mm_ = 0;
};

/// A place a line: x, y and z, mm, and columns behind them that are not used, with
/// blanks, commas, semicolons or tabs between them, as LinuxCNC's (PROBEOPEN) writes it;
/// or [PRB:x,y,z:1], as Grbl answers. Lines that begin with '#', ';', '(' or '%' are
/// comments, as are others of Grbl ("ok", "<...>"). `zero_mm` is subtracted from each
/// place. The places form a grid in any order, within 50 um. `text` up to 64 MiB.
///
/// kUnreadable, with the line: no number, a probe that touched nothing (":0]"), two
/// heights of one place. kMissing: a place of the grid without a height, fewer than 2 x
/// 2, or [PRB:] without zero_mm, since these are places of the machine. kTooLarge: more
/// than a million places.
Result<HeightMap> ParseHeightMap(std::string_view text, std::string_view file,
                                 const std::vector<double>& zero_mm = {});

/// Places of a grid over a box, at most `step_mm` apart, in rows that go forth and back.
std::vector<Vec2> ProbePlaces(const Vec2& min_mm, const Vec2& max_mm, double step_mm);

}  // namespace intaglio::post
