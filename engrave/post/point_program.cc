#include "engrave/post/point_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"

namespace intaglio::post {
namespace {

constexpr std::string_view kFrameVariables[] = {"NAME", "COUNT", "POWER", "N"};
constexpr std::string_view kPointVariables[] = {"I",  "X",  "Y",  "Z",  "SX",    "SY",
                                                "SZ", "EX", "EY", "EZ", "POWER", "N"};
constexpr FragmentRule kFragments[] = {{"begin", false, kFrameVariables},
                                       {"point", true, kPointVariables},
                                       {"end", false, kFrameVariables}};
constexpr SettingRule kSettings[] = {
    {"mark", 1e-4, 1}, {"flat", 0, 1}, {"turning", 0, 3}};
constexpr TemplateRules kRules{kFragments, kSettings};
enum { kBegin, kPoint, kEnd };

bool Uses(const Template& program, std::string_view variable) {
  return UsesVariable(program, kRules, kPoint, variable);
}

std::string OneLine(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return text;
}

/// The direction of the mark through a point: from the point before.
Vec3 DirectionTo(const PointList& axes, std::size_t i) {
  if (i == 0) return Vec3::UnitX();
  const Vec3 way = axes[i] - axes[i - 1];
  return way.norm() > 0 ? Vec3(way.normalized()) : Vec3::UnitX();
}

std::array<Value, std::size(kPointVariables)> ValuesOf(const PointList& axes,
                                                       std::size_t i, double mark_mm,
                                                       double power_ratio) {
  const Vec3 half = 0.5 * mark_mm * DirectionTo(axes, i);
  const Vec3 p = axes[i], from = p - half, to = p + half;
  return {std::uint64_t{i + 1},
          p.x(),
          p.y(),
          p.z(),
          from.x(),
          from.y(),
          from.z(),
          to.x(),
          to.y(),
          to.z(),
          power_ratio,
          std::uint64_t{0}};
}

Status RequireAxes(const Template& program, int turning_count) {
  const auto made_for = static_cast<std::uint64_t>(program.SettingOf("turning", 0));
  if (made_for != static_cast<std::uint64_t>(turning_count)) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: this template is for {} that {}, the machine has {}; "
                    "choose or write a template with '#turning {}'",
                    program.file, Counted(made_for, "axis", "axes"),
                    VerbFor(made_for, "turns", "turn"), turning_count, turning_count));
  }
  if (program.SettingOf("mark", 0) > 0 && turning_count > 0) {
    return Fail(ErrorCode::kUnsupported,
                program.file + ": marks of a length need three axes that do not turn");
  }
  return {};
}

/// A template that has no Z loses the depth of the points.
Status RequireFlat(const Template& program, const PointList& axes) {
  const auto flat = program.settings.find("flat");
  if (flat == program.settings.end() || axes.empty()) return {};
  const auto [low, high] =
      std::ranges::minmax_element(axes, {}, [](const Vec3& p) { return p.z(); });
  if (high->z() - low->z() <= flat->second) return {};
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("{}: this controller has no z, and the points lie between z {:.3f} "
                  "and {:.3f} mm; choose a machine with three axes, or engrave one "
                  "layer",
                  program.file, low->z(), high->z()));
}

/// A template that does not set the power at every point loses it.
Status RequirePower(const Template& program, const PointProgram& points) {
  if (points.power_ratios.empty() || Uses(program, "POWER")) return {};
  return Fail(ErrorCode::kUnsupported,
              program.file +
                  ": fragment 'point' does not use @POWER@, and the points have several "
                  "pulse energies; add it, or write a program for each energy");
}

}  // namespace

Result<Template> ParsePointTemplate(std::string_view text, std::string_view file) {
  Template program = INTAGLIO_TRY(ParseTemplate(text, file, kRules));
  const bool flat = program.settings.contains("flat");
  const bool marks = program.settings.contains("mark");
  for (const std::string_view axis : {"X", "Y", "Z"}) {
    if (flat && axis == "Z") continue;
    const std::string start = fmt::format("S{}", axis), end = fmt::format("E{}", axis);
    if (Uses(program, axis) || (Uses(program, start) && Uses(program, end))) continue;
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: fragment 'point' uses neither @{}@ nor @{}@ and @{}@, so "
                    "this coordinate would be lost",
                    file, axis, start, end));
  }
  for (const std::string_view end : {"SX", "SY", "SZ", "EX", "EY", "EZ"}) {
    if (marks || !Uses(program, end)) continue;
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: @{}@ needs the length of the mark; add #mark", file, end));
  }
  return program;
}

Status WritePointProgram(const std::filesystem::path& file, const Template& program,
                         const PointProgram& points) {
  const double mark_mm = program.SettingOf("mark", 0);
  INTAGLIO_TRY(RequireAxes(program, points.turning_count));
  INTAGLIO_TRY(RequireFlat(program, points.axes));
  INTAGLIO_TRY(RequirePower(program, points));
  io::AtomicFile out = INTAGLIO_TRY(io::AtomicFile::Create(file));
  const std::string name = OneLine(points.name);
  const std::array<Value, 4> frame = {std::string_view(name),
                                      std::uint64_t{points.axes.size()},
                                      points.power_ratio, std::uint64_t{0}};
  Expander expander(program, kRules);
  std::string text;
  expander.Append(kBegin, frame, text);
  for (std::size_t i = 0; i < points.axes.size(); ++i) {
    const double power_ratio =
        points.power_ratios.empty() ? points.power_ratio : points.power_ratios[i];
    expander.Append(kPoint, ValuesOf(points.axes, i, mark_mm, power_ratio), text);
    if (text.size() < (std::size_t{1} << 16)) continue;
    INTAGLIO_TRY(out.Write(text));
    text.clear();
  }
  expander.Append(kEnd, frame, text);
  INTAGLIO_TRY(out.Write(text));
  return out.Commit();
}

}  // namespace intaglio::post
