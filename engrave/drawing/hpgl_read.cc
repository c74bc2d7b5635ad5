#include "engrave/drawing/hpgl_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/hpgl_scale.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

constexpr double kPlotterUnit_mm = 0.025;
constexpr char kEndOfText = '\x03';
constexpr char kEscape = '\x1B';

bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool IsNumberPart(char c) {
  return (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
}
char Upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

class HpglReader {
 public:
  HpglReader(std::string_view text, const ReadOptions& options, std::string_view name)
      : text_(text),
        unit_mm_(options.unit_mm.value_or(kPlotterUnit_mm)),
        limits_(options.limits),
        builder_(name, options.limits) {}

  Result<Drawing> Read() {
    if (text_.size() > limits_.max_file_bytes) {
      builder_.Refuse(ErrorCode::kTooLarge, "",
                      fmt::format("the file has {} bytes, the limit is {}; divide the "
                                  "drawing or raise the limit",
                                  text_.size(), limits_.max_file_bytes));
      return builder_.Take();
    }
    bool good = true;
    while (good && at_ < text_.size()) good = ReadInstruction();
    if (good && EndLine() && !any_) {
      builder_.Refuse(
          ErrorCode::kUnreadable, "",
          "the file has no HPGL instruction such as PU or PA; it is not HPGL");
    }
    return builder_.Take();
  }

 private:
  std::string Place() const { return fmt::format("byte {}, {}", begin_, name_); }
  bool Refuse(ErrorCode code, std::string_view sentence, std::string_view value = {}) {
    return builder_.Refuse(code, Place(), sentence, value);
  }

  /// False after an error.
  bool ReadInstruction() {
    while (at_ < text_.size() && !IsLetter(text_[at_]) && text_[at_] != kEscape) ++at_;
    if (at_ == text_.size()) return true;
    begin_ = at_;
    if (text_[at_] == kEscape) {
      SkipEscape();
      return true;
    }
    if (at_ + 1 >= text_.size() || !IsLetter(text_[at_ + 1])) {
      name_ = Shown(text_.substr(at_, 2));
      return Refuse(
          ErrorCode::kUnreadable,
          "expected the two letters of an instruction; the file is damaged or not HPGL",
          text_.substr(at_, 8));
    }
    name_ = {Upper(text_[at_]), Upper(text_[at_ + 1])};
    at_ += 2;
    return Do();
  }

  /// ESC . letter [numbers :], or ESC % digits letter.
  void SkipEscape() {
    builder_.LeaveOut("ESC");
    ++at_;
    const bool dotted = at_ < text_.size() && text_[at_] == '.';
    if (dotted) ++at_;
    if (!dotted) {
      while (at_ < text_.size() && !IsLetter(text_[at_])) ++at_;
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

  /// All numbers of an instruction that has few; at least `least` of them are required.
  bool Numbers(std::size_t smallest, std::vector<double>& numbers) {
    bool ok = true;
    while (const std::optional<double> number = NextNumber(ok)) {
      if (numbers.size() == 8)
        return Refuse(ErrorCode::kInvalidValue, "too many numbers");
      numbers.push_back(*number);
    }
    if (!ok || numbers.size() >= smallest) return ok;
    return Refuse(ErrorCode::kInvalidValue,
                  fmt::format("needs {} numbers, got {}; plot the drawing again",
                              smallest, numbers.size()));
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
      name_ == "IN" ? scale_.Initialize() : scale_.SwitchOff();
      relative_ = down_ = false;
      return EndLine();
    }
    builder_.LeaveOut(name_);
    if (name_ == "LB" || name_ == "BL") {
      at_ = std::min(text_.find(kEndOfText, at_), text_.size());
    } else {
      at_ = std::min(text_.find_first_of(";\n", at_), text_.size());
    }
    return true;
  }

  bool Pen() {
    any_ = true;
    if (name_ == "PU" || name_ == "PD") {
      if (name_ == "PU" && !EndLine()) return false;
      down_ = name_ == "PD";
    } else {
      relative_ = name_ == "PR";
    }
    if (down_ && line_.empty()) line_.push_back(pen_);
    bool ok = true;
    while (const std::optional<double> x = NextNumber(ok)) {
      const std::optional<double> y = NextNumber(ok);
      if (!ok) return false;
      if (!y) return Refuse(ErrorCode::kInvalidValue, "a coordinate has no y");
      if (!UnitsKnown()) return false;
      pen_ = PointAtUser(*x, *y, relative_);
      if (!down_) continue;
      line_.push_back(pen_);
      if (line_.size() > limits_.max_points) {
        return builder_.CountPoints(line_.size(), Place());
      }
    }
    return ok;
  }

  /// x, y of the centre, sweep in degrees, chord angle (not needed: arcs are exact).
  bool Arc() {
    std::vector<double> n;
    if (!Numbers(3, n) || !UnitsKnown()) return false;
    const Vec3 center = PointAtUser(n[0], n[1], name_ == "AR");
    // Round in user units: where these are stretched, an ellipse.
    const Vec2 u = (pen_ - center).head<2>().cwiseQuotient(scale_.factor());
    const double sweep = std::clamp(n[2], -360.0, 360.0) * pi / 180;
    const EllipticArc arc{center, AxisOfUser(u.x(), u.y()), AxisOfUser(-u.y(), u.x()), 0,
                          sweep};
    pen_ = PointAt(arc, 1);
    if (!down_) return true;
    FlushLine();
    pieces_.push_back(arc);
    line_.push_back(pen_);
    return pieces_.size() <= limits_.max_points / 3 ||
           builder_.CountPoints(3 * pieces_.size(), Place());
  }

  bool Circle() {
    std::vector<double> n;
    if (!Numbers(1, n) || !UnitsKnown()) return false;
    const double r = std::abs(n[0]);
    if (!(r > 0)) return Refuse(ErrorCode::kInvalidValue, "the radius must not be 0");
    return Shape({EllipticArc{pen_, AxisOfUser(r, 0), AxisOfUser(0, r), 0, 2 * pi}});
  }

  bool Box() {
    std::vector<double> n;
    if (!Numbers(2, n) || !UnitsKnown()) return false;
    const bool from_pen = name_ == "ER" || name_ == "RR";
    const Vec3 p = pen_;
    const Vec3 q = PointAtUser(n[0], n[1], from_pen);
    return Shape({Polyline{{p, {q.x(), p.y(), 0}, q, {p.x(), q.y(), 0}}}});
  }

  /// Radius, beginning and sweep in degrees, about the pen.
  bool Wedge() {
    std::vector<double> n;
    if (!Numbers(3, n) || !UnitsKnown()) return false;
    const double r = n[0];
    const EllipticArc arc{pen_, AxisOfUser(r, 0), AxisOfUser(0, r),
                          std::fmod(n[1], 360) * pi / 180,
                          std::clamp(n[2], -360.0, 360.0) * pi / 180};
    return Shape({Polyline{{pen_}}, arc});
  }

  bool SelectPen() {
    any_ = true;
    std::vector<double> n;
    if (!Numbers(0, n)) return false;
    if (!EndLine()) return false;
    layer_ = n.empty() || n[0] == 0 ? 0 : builder_.NameIndex(fmt::format("SP{}", n[0]));
    return true;
  }

  bool Scale() {
    any_ = true;
    std::vector<double> n;
    if (!Numbers(0, n)) return false;
    if (name_ == "IR" && !n.empty()) {
      scale_.TakePointsOfPage();
      return true;
    }
    const auto wrong = name_ == "SC" ? scale_.TakeScale(n) : scale_.TakePoints(n);
    return !wrong || Refuse(wrong->code, wrong->sentence);
  }
  bool UnitsKnown() {
    const auto& wrong = scale_.wrong();
    return !wrong || Refuse(wrong->code, wrong->sentence);
  }

  /// Plotter units of a vector and of a point in user units.
  Vec3 AxisOfUser(double x, double y) const {
    return {scale_.factor().x() * x, scale_.factor().y() * y, 0};
  }
  Vec3 PointAtUser(double x, double y, bool from_pen) const {
    const Vec3 origin(scale_.offset().x(), scale_.offset().y(), 0);
    return (from_pen ? pen_ : origin) + AxisOfUser(x, y);
  }

  bool Shape(std::vector<Piece> pieces) {
    any_ = true;
    return AddCurve({std::move(pieces), true, layer_, 0});
  }

  void FlushLine() {
    if (line_.size() > 1) pieces_.push_back(Polyline{std::move(line_)});
    line_.clear();
  }
  bool EndLine() {
    // A pen that goes down and up again leaves a point.
    if (line_.size() == 1 && pieces_.empty()) {
      pieces_.push_back(Polyline{std::exchange(line_, {})});
    }
    FlushLine();
    if (pieces_.empty()) return true;
    return AddCurve({std::exchange(pieces_, {}), false, layer_, 0});
  }
  bool AddCurve(Curve curve) {
    if (!builder_.CountEntity(Place())) return false;
    for (Piece& piece : curve.pieces) {
      Transform(unit_mm_ * Mat3::Identity(), Vec3::Zero(), piece);
    }
    return builder_.Add(std::move(curve), Place());
  }

  std::string_view text_;
  double unit_mm_;
  DrawingLimits limits_;
  DrawingBuilder builder_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;
  std::string name_;
  bool any_ = false;
  bool down_ = false;
  bool relative_ = false;
  std::uint32_t layer_ = 0;
  HpglScale scale_;
  Vec3 pen_ = Vec3::Zero();  ///< plotter units, as all that is stored
  PointList line_;
  std::vector<Piece> pieces_;
};

}  // namespace

Result<Drawing> ReadHpgl(std::string_view text, const ReadOptions& options,
                         std::string_view name) {
  RequireUsable(options);
  return HpglReader(text, options, name).Read();
}

}  // namespace intaglio::drawing
