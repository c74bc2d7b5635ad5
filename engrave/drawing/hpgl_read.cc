#include "engrave/drawing/hpgl_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/hpgl_commands.h"
#include "engrave/drawing/hpgl_encoded.h"
#include "engrave/drawing/hpgl_pen.h"
#include "engrave/drawing/pieces.h"
#include "engrave/io/lower_case.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;
constexpr double kPlotterUnit_mm = 0.025;
constexpr char kEndOfText = '\x03', kEscape = '\x1B';
bool IsNumberPart(char c) {
  return (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
}
char Upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

class HpglReader {
 public:
  HpglReader(std::string_view text, const ReadOptions& options, std::string_view name)
      : text_(text),
        pen_(name, options.limits, options.unit_mm.value_or(kPlotterUnit_mm)) {
    pen_.builder().NoteUnitAskedFor("plotter", options.unit_mm);
  }

  Result<Drawing> Read() {
    if (!pen_.builder().CheckSize(text_.size())) return pen_.builder().Take();
    bool good = true;
    while (good && at_ < text_.size()) good = ReadInstruction();
    if (good && pen_.EndLine() && !any_) {
      pen_.builder().Refuse(
          ErrorCode::kUnreadable, "",
          "the file has no HPGL instruction such as PU or PA; it is not HPGL");
    }
    return pen_.builder().Take();
  }

 private:
  std::string Place() const { return fmt::format("byte {}, {}", begin_, name_); }
  bool Refuse(ErrorCode code, std::string_view sentence, std::string_view value = {}) {
    return pen_.builder().Refuse(code, pen_.Place(), sentence, value);
  }

  /// False after an error.
  bool ReadInstruction() {
    while (at_ < text_.size() && !io::IsLetter(text_[at_]) && text_[at_] != kEscape)
      ++at_;
    if (at_ == text_.size()) return true;
    begin_ = at_;
    if (text_[at_] == kEscape) {
      SkipEscape();
      return true;
    }
    if (at_ + 1 >= text_.size() || !io::IsLetter(text_[at_ + 1])) {
      name_ = Shown(text_.substr(at_, 2));
      pen_.SetPlace(begin_, name_);
      return Refuse(
          ErrorCode::kUnreadable,
          "expected the two letters of an instruction; the file is damaged or not HPGL",
          text_.substr(at_, 8));
    }
    name_ = {Upper(text_[at_]), Upper(text_[at_ + 1])};
    at_ += 2;
    pen_.SetPlace(begin_, name_);
    return Do();
  }

  void LeaveOut(std::string_view what) {
    pen_.builder().LeaveOut(what, EffectOfHpgl(what, drawn_.IsAround(begin_)),
                            fmt::format("byte {}", begin_));
  }

  /// ESC . letter [numbers :], or ESC % digits letter.
  void SkipEscape() {
    LeaveOut("ESC");
    ++at_;
    const bool dotted = at_ < text_.size() && text_[at_] == '.';
    if (dotted) ++at_;
    if (!dotted) {
      while (at_ < text_.size() && !io::IsLetter(text_[at_])) ++at_;
    }
    at_ = std::min(at_ + 1, text_.size());
    if (!dotted) return;
    std::size_t end = at_;
    while (end < text_.size() && (IsNumberPart(text_[end]) || text_[end] == ';')) ++end;
    if (end < text_.size() && text_[end] == ':') at_ = end + 1;
  }

  /// The next number of the instruction; none at its end. `ok` false: an error.
  std::optional<double> NextNumber(bool& ok) {
    while (at_ < text_.size() &&
           (text_[at_] == ',' || text_[at_] == ' ' || text_[at_] == '\t' ||
            text_[at_] == '\r' || text_[at_] == '\n')) {
      ++at_;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && (IsNumberPart(text_[at_]))) {
      // A sign begins the next number.
      if (at_ > begin && (text_[at_] == '+' || text_[at_] == '-')) break;
      ++at_;
    }
    if (at_ == begin) return std::nullopt;
    const std::optional<double> number = NumberOf(text_.substr(begin, at_ - begin));
    if (!number) {
      ok = Refuse(ErrorCode::kInvalidValue,
                  "expected a finite number; export the drawing again",
                  text_.substr(begin, at_ - begin));
    }
    return number;
  }

  /// All numbers of an instruction that has few, `smallest` or more.
  bool Numbers(std::size_t smallest, std::vector<double>& numbers) {
    bool ok = true;
    while (const std::optional<double> number = NextNumber(ok)) {
      if (numbers.size() == 8)
        return Refuse(ErrorCode::kInvalidValue, "too many numbers");
      numbers.push_back(*number);
    }
    if (!ok || numbers.size() >= smallest) return ok;
    return Refuse(ErrorCode::kInvalidValue,
                  fmt::format("needs {}, got {}; plot the drawing again",
                              Counted(smallest, "number"), numbers.size()));
  }

  bool Do() {
    if (name_ == "PU" || name_ == "PD" || name_ == "PA" || name_ == "PR") return Pen();
    if (name_ == "AA" || name_ == "AR") return Arc();
    if (name_ == "CI") return Circle();
    if (name_ == "EA" || name_ == "ER" || name_ == "RA" || name_ == "RR") return Box();
    if (name_ == "EW" || name_ == "WG") return Wedge();
    if (name_ == "SP") return SelectPen();
    if (name_ == "SC" || name_ == "IP" || name_ == "IR") return Scale();
    if (name_ == "IN" || name_ == "DF") {
      any_ = true;
      name_ == "IN" ? pen_.scale().Initialize() : pen_.scale().SwitchOff();
      if (name_ == "IN") pen_.Turn(0);
      end_of_text_ = kEndOfText;
      relative_ = false;
      return pen_.SetDown(false);
    }
    if (name_ == "RO") return Rotate();
    if (name_ == "AT" || name_ == "RT") return ArcThrough();
    if (name_ == "BZ" || name_ == "BR") return Beziers();
    if (name_ == "PE") return Encoded();
    if (name_ == "DT") return DefineTerminator();
    return LeaveOutInstruction();
  }

  bool LeaveOutInstruction() {
    const bool has_numbers = at_ < text_.size() && text_[at_] != ';' &&
                             (name_ == "SM" || !io::IsLetter(text_[at_]));
    if (name_ == "LB" || name_ == "BL" || name_ == "WD") {
      LeaveOut(name_);
      at_ = std::min(text_.find(end_of_text_, at_), text_.size() - 1) + 1;
      return true;
    }
    // Without numbers they bring the plotter's own back.
    if (has_numbers || EffectOfHpgl(name_, false) != Effect::kChanged) LeaveOut(name_);
    if (name_ == "SM" && at_ < text_.size() && text_[at_] != ';') ++at_;  // a symbol
    // HP-GL/2 needs no semicolon before the next letters; a text in quotes has letters.
    while (at_ < text_.size() && !io::IsLetter(text_[at_]) && text_[at_] != kEscape &&
           text_[at_] != ';' && text_[at_] != '\n') {
      const auto close = text_[at_] == '"' ? text_.find('"', at_ + 1) : text_.npos;
      at_ = close == text_.npos ? at_ + 1 : close + 1;
    }
    return true;
  }

  /// DT character [, mode]: what ends a label. Without: the byte 3.
  bool DefineTerminator() {
    end_of_text_ = kEndOfText;
    if (at_ < text_.size() && text_[at_] != ';') end_of_text_ = text_[at_++];
    at_ = std::min(text_.find(';', at_), text_.size());
    return true;
  }

  bool Rotate() {
    std::vector<double> n;
    if (!Numbers(0, n)) return false;
    const double quarters = (n.empty() ? 0 : n[0]) / 90;
    if (quarters != std::floor(quarters) || std::abs(quarters) > 4) {
      return Refuse(ErrorCode::kInvalidValue,
                    "a plot is turned by 0, 90, 180 or 270 degrees; plot it again");
    }
    pen_.Turn((static_cast<int>(quarters) + 4) % 4);
    return true;
  }

  bool Pen() {
    any_ = true;
    if (name_ == "PU" || name_ == "PD") {
      if (!pen_.SetDown(name_ == "PD")) return false;
    } else {
      relative_ = name_ == "PR";
    }
    if (!pen_.SetDown(pen_.down())) return false;
    bool ok = true;
    while (const std::optional<double> x = NextNumber(ok)) {
      const std::optional<double> y = NextNumber(ok);
      if (!ok) return false;
      if (!y) return Refuse(ErrorCode::kInvalidValue, "a coordinate has no y");
      if (!UnitsKnown()) return false;
      if (!pen_.LineTo(pen_.PointAtUser(*x, *y, relative_))) return false;
    }
    return ok;
  }

  /// x, y of the centre, sweep in degrees, chord angle (not needed: arcs are exact).
  bool Arc() {
    std::vector<double> n;
    if (!Numbers(3, n) || !UnitsKnown()) return false;
    const Vec3 center = pen_.PointAtUser(n[0], n[1], name_ == "AR");
    // Round in user units: where these are stretched, an ellipse.
    const Vec2 u = pen_.UserVector(pen_.at() - center);
    const double sweep = std::clamp(n[2], -360.0, 360.0) * pi / 180;
    return DrawArc({center, pen_.AxisOfUser(u.x(), u.y()), pen_.AxisOfUser(-u.y(), u.x()),
                    0, sweep});
  }

  /// From the pen through a point to an end.
  bool ArcThrough() {
    std::vector<double> n;
    if (!Numbers(4, n) || !UnitsKnown()) return false;
    const bool from_pen = name_ == "RT";
    const Vec3 middle = pen_.PointAtUser(n[0], n[1], from_pen);
    const Vec3 end = pen_.PointAtUser(n[2], n[3], from_pen);
    const Vec2 m = pen_.UserVector(middle - pen_.at()),
               e = pen_.UserVector(end - pen_.at());
    const double cross = m.x() * e.y() - m.y() * e.x();
    Vec2 center = m / 2;  // of a full circle, whose end is its beginning
    if (!e.isZero(0)) {
      if (std::abs(cross) < 1e-9 * m.norm() * e.norm() || m.isZero(0)) {
        return pen_.LineTo(middle) && pen_.LineTo(end);
      }
      center = Vec2(e.y() * m.squaredNorm() - m.y() * e.squaredNorm(),
                    m.x() * e.squaredNorm() - e.x() * m.squaredNorm()) /
               (2 * cross);
    } else if (m.isZero(0)) {
      return true;
    }
    const Vec2 u = -center, to = e - center;
    double sweep = std::atan2(u.x() * to.y() - u.y() * to.x(), u.dot(to));
    if (e.isZero(0)) sweep = 2 * pi;
    if (cross > 0 && sweep <= 0) sweep += 2 * pi;
    if (cross < 0 && sweep >= 0) sweep -= 2 * pi;
    // The middle lies to the left of the chord when the arc turns to the right.
    return DrawArc({pen_.at() + pen_.AxisOfUser(center.x(), center.y()),
                    pen_.AxisOfUser(u.x(), u.y()), pen_.AxisOfUser(-u.y(), u.x()), 0,
                    sweep});
  }

  bool Beziers() {
    any_ = true;
    bool ok = true;
    while (true) {
      std::array<double, 6> n{};
      std::size_t count = 0;
      for (; count < n.size(); ++count) {
        const std::optional<double> number = NextNumber(ok);
        if (!ok) return false;
        if (!number) break;
        n.at(count) = *number;
      }
      if (count == 0) return true;
      if (count < n.size()) {
        return Refuse(ErrorCode::kInvalidValue,
                      "a Bezier curve has three points; plot the drawing again");
      }
      if (!UnitsKnown()) return false;
      const bool from_pen = name_ == "BR";
      const CubicBezier curve{{pen_.at(), pen_.PointAtUser(n[0], n[1], from_pen),
                               pen_.PointAtUser(n[2], n[3], from_pen),
                               pen_.PointAtUser(n[4], n[5], from_pen)}};
      if (!pen_.Draw(curve, curve.control_mm[3])) return false;
    }
  }

  bool Encoded() {
    any_ = true;
    HpglEncoded encoded(text_, at_);
    while (true) {
      const HpglStep step = encoded.Next();
      at_ = encoded.position();
      if (step.kind == HpglStep::Kind::kEnd) return true;
      if (step.kind == HpglStep::Kind::kWrong) {
        return Refuse(ErrorCode::kInvalidValue,
                      "a number of the encoded polyline is cut or too large; plot the "
                      "drawing again");
      }
      if (step.kind == HpglStep::Kind::kPen) {
        if (!pen_.Select(step.pen)) return false;
        continue;
      }
      if (!UnitsKnown() || (!step.down && !pen_.EndLine())) return false;
      pen_.Move(step.down);
      if (!pen_.LineTo(pen_.PointAtUser(step.at.x(), step.at.y(), !step.absolute)))
        return false;
    }
  }

  bool DrawArc(const EllipticArc& arc) { return pen_.Draw(arc, PointAt(arc, 1)); }

  bool Circle() {
    std::vector<double> n;
    if (!Numbers(1, n) || !UnitsKnown()) return false;
    const double r = std::abs(n[0]);
    if (!(r > 0)) return Refuse(ErrorCode::kInvalidValue, "the radius must not be 0");
    any_ = true;
    return pen_.Shape({EllipticArc{pen_.at(), pen_.AxisOfUser(r, 0),
                                   pen_.AxisOfUser(0, r), 0, 2 * pi}});
  }

  bool Box() {
    std::vector<double> n;
    if (!Numbers(2, n) || !UnitsKnown()) return false;
    const bool from_pen = name_ == "ER" || name_ == "RR";
    const Vec3 p = pen_.at();
    const Vec3 q = pen_.PointAtUser(n[0], n[1], from_pen);
    const Vec2 d = pen_.UserVector(q - p);
    any_ = true;
    return pen_.Shape(
        {Polyline{{p, p + pen_.AxisOfUser(d.x(), 0), q, p + pen_.AxisOfUser(0, d.y())}}});
  }

  /// Radius, beginning and sweep in degrees, about the pen.
  bool Wedge() {
    std::vector<double> n;
    if (!Numbers(3, n) || !UnitsKnown()) return false;
    const double r = n[0];
    const EllipticArc arc{pen_.at(), pen_.AxisOfUser(r, 0), pen_.AxisOfUser(0, r),
                          std::fmod(n[1], 360) * pi / 180,
                          std::clamp(n[2], -360.0, 360.0) * pi / 180};
    any_ = true;
    return pen_.Shape({Polyline{{pen_.at()}}, arc});
  }

  bool SelectPen() {
    any_ = true;
    std::vector<double> n;
    if (!Numbers(0, n)) return false;
    return pen_.Select(n.empty() ? 0 : n[0]);
  }

  bool Scale() {
    any_ = true;
    std::vector<double> n;
    if (!Numbers(0, n)) return false;
    if (name_ == "IR" && !n.empty()) {
      pen_.scale().TakePointsOfPage();
      return true;
    }
    const auto wrong =
        name_ == "SC" ? pen_.scale().TakeScale(n) : pen_.scale().TakePoints(n);
    return !wrong || Refuse(wrong->code, wrong->sentence);
  }
  bool UnitsKnown() {
    const auto& wrong = pen_.scale().wrong();
    return !wrong || Refuse(wrong->code, wrong->sentence);
  }

  std::string_view text_;
  HpglDrawn drawn_{text_};
  HpglPen pen_;
  std::size_t at_ = 0, begin_ = 0;
  std::string name_;
  bool any_ = false, relative_ = false;
  char end_of_text_ = kEndOfText;
};

}  // namespace

Result<Drawing> ReadHpgl(std::string_view text, const ReadOptions& options,
                         std::string_view name) {
  RequireUsable(options);
  return HpglReader(text, options, name).Read();
}

}  // namespace intaglio::drawing
