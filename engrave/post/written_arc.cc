// With a radius of n last decimals the angles of rounded ends about a rounded centre are
// wrong by no more than about 3 / n. A sweep that differs by kMaxTurnRad or more is
// either that of a whole turn or of an arc that is as small as a few decimals.
#include "engrave/post/written_arc.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/io/number_text.h"

namespace intaglio::post {
namespace {

constexpr double kMaxTurnRad = 0.5;
/// Controllers refuse arcs with a smaller radius: rs274 below 1 um.
constexpr double kMinRadiusMm = 2e-3;
/// Halves of a whole turn with the radius of 10 m in nm.
constexpr int kMaxDivisions = 40;

class ArcWriter {
 public:
  ArcWriter(const Template& program, const ArcVariables& variables, const Vec2& origin_mm)
      : program_(program), variables_(variables), origin_mm_(origin_mm) {
    for (const char* variable : {"X", "Y"}) {
      const NumberFormat format = program.FormatOf(variable);
      decimal_mm_ =
          std::max(decimal_mm_, std::pow(10.0, -format.decimals) / format.scale);
    }
  }

  void Append(const Vec2& begin_mm, const WorkMove& move, std::vector<WorkMove>& moves,
              int divisions = 0) const {
    if (move.kind == WorkKind::kLine || !variables_.place || Keeps(begin_mm, move)) {
      moves.push_back(move);
      return;
    }
    if (IsFlat(move) || divisions == kMaxDivisions) {
      if (Place(begin_mm) == Place(move.end_mm)) return;
      WorkMove line = LineTo(move.end_mm);
      KeepTabAndSpeed(move, line);
      moves.push_back(line);
      return;
    }
    const Vec2 center_mm = begin_mm + move.center_from_begin_mm;
    Append(begin_mm, Half(begin_mm, move.middle_mm, center_mm, move), moves,
           divisions + 1);
    Append(move.middle_mm, Half(move.middle_mm, move.end_mm, center_mm, move), moves,
           divisions + 1);
  }

 private:
  double Number(double value, std::string_view variable) const {
    const NumberFormat format = program_.FormatOf(variable);
    std::string text;
    AppendNumber(value, format, text);
    const auto number = io::ParseFinite(text);
    Require(number.has_value(), "a number is written as {}", text);
    return *number / format.scale;
  }
  Vec2 Place(const Vec2& place_mm) const {
    return {Number(place_mm.x() - origin_mm_.x(), "X"),
            Number(place_mm.y() - origin_mm_.y(), "Y")};
  }

  bool IsFlat(const WorkMove& move) const {
    const double half = std::min(move.sweep_rad, std::numbers::pi) / 2;
    return move.radius_mm * (1 - std::cos(half)) < decimal_mm_ / 2;
  }

  /// Whether the arc stays one.
  bool Keeps(const Vec2& begin_mm, const WorkMove& move) const {
    if (variables_.angle) return true;
    if (IsFlat(move) || move.radius_mm < kMinRadiusMm) return false;
    const Vec2 begin = Place(begin_mm), end = Place(move.end_mm);
    if (begin == end) return false;
    if (variables_.center) {
      const Vec2 center = begin + Vec2(Number(move.center_from_begin_mm.x(), "I"),
                                       Number(move.center_from_begin_mm.y(), "J"));
      const Vec2 exact_center = begin_mm + move.center_from_begin_mm;
      if (begin == center || end == center) return false;
      const double turned = SweepRad(begin, end, center, move.kind);
      const double exact = SweepRad(begin_mm, move.end_mm, exact_center, move.kind);
      if (std::abs(turned - exact) >= kMaxTurnRad) return false;
    }
    if (!variables_.middle) return true;
    const Vec2 middle(Number(move.middle_mm.x() - origin_mm_.x(), "AX"),
                      Number(move.middle_mm.y() - origin_mm_.y(), "AY"));
    const double turn = contour::Cross(middle - begin, end - middle);
    return move.kind == WorkKind::kCounterClockwise ? turn > 0 : turn < 0;
  }

  static double SweepRad(const Vec2& begin, const Vec2& end, const Vec2& center,
                         WorkKind kind) {
    const bool left = kind == WorkKind::kCounterClockwise;
    return std::abs(contour::MakeArcBetween(begin, end, center, left).sweep_rad);
  }

  static WorkMove Half(const Vec2& begin_mm, const Vec2& end_mm, const Vec2& center_mm,
                       const WorkMove& whole) {
    WorkMove half = whole;
    half.end_mm = end_mm;
    half.sweep_rad = whole.sweep_rad / 2;
    half.center_from_begin_mm = center_mm - begin_mm;
    const double quarter = whole.kind == WorkKind::kCounterClockwise
                               ? half.sweep_rad / 2
                               : -half.sweep_rad / 2;
    const Vec2 from = begin_mm - center_mm;
    const double angle = std::atan2(from.y(), from.x()) + quarter;
    half.middle_mm = center_mm + whole.radius_mm * Vec2(std::cos(angle), std::sin(angle));
    return half;
  }

  const Template& program_;
  ArcVariables variables_;
  Vec2 origin_mm_;
  double decimal_mm_ = 0;
};

}  // namespace

ToolPath WritablePath(const ToolPath& path, const Template& program,
                      const ArcVariables& variables, const Vec2& origin_mm) {
  const ArcWriter writer(program, variables, origin_mm);
  ToolPath written{path.name, path.begin_mm, {}};
  Vec2 at_mm = path.begin_mm;
  for (const WorkMove& move : path.moves) {
    writer.Append(at_mm, move, written.moves);
    at_mm = move.end_mm;
  }
  return written;
}

}  // namespace intaglio::post
