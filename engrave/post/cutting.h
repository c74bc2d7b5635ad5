#pragma once

// How a tool works along contours and in holes, and the texts that come of it. Common to
// the templates of milling (mill_program.h) and of drilling (drill_program.h). Common
// variables, in every fragment:
//   NAME       text: the program's name, letters, digits and '_' alone
//   N          number of the line, from 1 in every program
//   SPEED      at work, mm/s; in mm/min with `#number SPEED scale=60`
//   TRAVEL     between contours and holes, mm/s
//   PLUNGE     down into the work, mm/s
//   DEPTH      z of the work, mm: 0 on the surface, negative below it
//   SAFE       z of the way between, mm
//   POWER      of a laser, 0..1 of its largest
//   DIAMETER   of the tool, mm
// Common settings:
//   origin-x origin-y   subtracted from every place, mm (Siwiec 2016, ch. 4)
//   max-name            most characters of a program's name, else it is refused, 1..255
//   max-bytes           maximum size of a program; a longer one is divided, 200..1e9

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/post/template.h"

namespace intaglio::post {

struct Cutting {
  std::string name{};  ///< of the program; other characters become '_'
  double speed_mm_s = 5;
  double travel_mm_s = 50;
  double plunge_mm_s = 5;
  double safe_mm = 2;
  /// z of each time that a contour is made, mm, <= 0; one or more. All 0 of a laser.
  std::vector<double> depths_mm{-0.2};
  /// z of the top of tabs, mm, <= 0; nothing for tabs that no pass works on, as of a
  /// laser.
  std::optional<double> tab_top_mm{};
  std::optional<double> power_ratio{};  ///< of a laser, 0..1
  double tool_diameter_mm = 0.2;
  /// Variables that a person gave a value for: a template that does not use them is
  /// refused, because what was given would be lost.
  std::vector<std::string> given{};
};

/// The text of a program, and of the parts that it is divided into: each is a program of
/// its own, and all but the first have "_2", "_3" ... behind their name.
using ProgramTexts = std::vector<std::string>;

/// "a board-1" -> "a_board_1"; a leading digit or nothing gets "P" in front.
std::string ProgramName(std::string_view text);

/// Of part `part`, counted from 0: NAME, NAME_2, NAME_3 ...
std::string PartName(const std::string& name, std::size_t part);

/// kUnsupported, with the template's name and the remedy: a variable of `given` that no
/// fragment uses; POWER that is used and not known; depths that differ although only the
/// begin of the program (fragment 0) uses DEPTH.
Status RequireSuited(const Template& program, const TemplateRules& rules,
                     const Cutting& cutting);

/// The common variables as values, in the order of kCommonVariables.
std::vector<Value> CommonValues(const Cutting& cutting, std::string_view name,
                                double depth_mm);

inline constexpr std::array<std::string_view, 9> kCommonVariables = {
    "NAME", "N", "SPEED", "TRAVEL", "PLUNGE", "DEPTH", "SAFE", "POWER", "DIAMETER"};

/// Those, and others behind them.
template <std::size_t kCount>
constexpr auto WithCommon(const std::array<std::string_view, kCount>& others) {
  std::array<std::string_view, kCommonVariables.size() + kCount> all{};
  std::copy(kCommonVariables.begin(), kCommonVariables.end(), all.begin());
  std::copy(others.begin(), others.end(), all.begin() + kCommonVariables.size());
  return all;
}

inline constexpr SettingRule kOriginX{"origin-x", -10000, 10000};
inline constexpr SettingRule kOriginY{"origin-y", -10000, 10000};
inline constexpr SettingRule kMaxBytes{"max-bytes", 200, 1e9};
inline constexpr SettingRule kMaxName{"max-name", 1, 255};

/// kInvalidValue where the name of the last of so many parts is longer than the
/// template's max-name: the controller would not load it, and a file that has another
/// name than its program neither.
Status RequireName(const Template& program, const std::string& name,
                   std::size_t part_count);

}  // namespace intaglio::post
