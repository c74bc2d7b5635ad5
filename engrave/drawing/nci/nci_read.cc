#include "engrave/drawing/nci/nci_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/nci/nci_codes.h"
#include "engrave/drawing/pieces.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/text_behind.h"
#include "engrave/io/trimmed_line.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;
constexpr double kRapidFeed = -2;
constexpr double kMaxTool = 1e6;
// Files have four decimals and more of a millimetre or an inch.
constexpr double kSameRadiusUnits = 0.002, kSameRadiusRatio = 1e-3;
constexpr double kSameUnits = 1e-9;
constexpr std::size_t kMaxParameters = 64;
constexpr std::string_view kPostAgain = "post the operation again";

/// The next parameter of a trimmed line, which is taken off it.
std::string_view TakeParameter(std::string_view& rest) {
  const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
  const std::string_view word = rest.substr(0, end);
  rest = io::TrimmedLine(rest.substr(end));
  return word;
}

class NciReader {
 public:
  NciReader(std::string_view text, const ReadOptions& options, std::string_view name)
      : text_(io::WithoutByteOrderMark(text)),
        limits_(options.limits),
        unit_mm_(options.unit_mm.value_or(1)),
        builder_(name, options.limits) {
    builder_.SetUnit(unit_mm_);
  }

  Result<Drawing> Read() {
    if (builder_.CheckSize(text_.size())) ReadRecords();
    return builder_.Take();
  }

 private:
  std::string Place() const { return fmt::format("line {}, code {}", code_line_, code_); }
  bool Refuse(ErrorCode code, std::string_view sentence, std::string_view value = {}) {
    return builder_.Refuse(code, Place(), sentence, value);
  }

  /// False at the end of the file.
  bool NextLine(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    line = io::TrimmedLine(text_.substr(at_, end - at_));
    at_ = end + 1;
    ++line_;
    return true;
  }

  bool ReadRecords() {
    bool any = false;
    std::string_view line;
    while (NextLine(line)) {
      if (line.empty() || line == "\x1A") continue;
      if (!TakeCode(line)) return false;
      any = true;
      if (!NextLine(parameters_)) {
        return Refuse(ErrorCode::kUnreadable,
                      fmt::format("the line with the parameters of the code is missing; "
                                  "the file is cut short: {}",
                                  kPostAgain));
      }
      if (!Do()) return false;
      if (code_ == Number(NciCode::kEnd)) break;
    }
    if (!any) {
      return builder_.Refuse(ErrorCode::kUnreadable, "",
                             "the file has no record; it is not NCI, whose lines are "
                             "codes and parameters in turn");
    }
    if (code_ != Number(NciCode::kEnd)) {
      builder_.LeaveOut("end of the file (code 1003): it may be cut short", Effect::kLost,
                        fmt::format("line {}", line_), 0, kPostAgain);
    } else if (!io::TextBehind(text_, std::min(at_, text_.size())).empty()) {
      builder_.LeaveOut("text behind the end (code 1003)", Effect::kLost,
                        fmt::format("line {}", line_), 0, "divide the file");
    }
    return EndCurve();
  }

  static constexpr std::uint32_t Number(NciCode code) {
    return static_cast<std::uint32_t>(code);
  }

  bool TakeCode(std::string_view line) {
    const char* end = line.data() + line.size();
    const auto [stop, wrong] = std::from_chars(line.data(), end, code_);
    if (wrong == std::errc() && stop == end && code_ <= 99'999) {
      code_line_ = line_;
      return true;
    }
    return builder_.Refuse(
        ErrorCode::kUnreadable, fmt::format("line {}", line_),
        fmt::format("expected the number of a code, 0 to 99999, got \"{}\"; the file is "
                    "not NCI, or a line of it is missing",
                    Shown(line)),
        line);
  }

  /// The parameters as numbers, `smallest` or more.
  bool Numbers(std::size_t smallest) {
    numbers_.clear();
    std::string_view rest = parameters_;
    while (!rest.empty()) {
      const std::string_view word = TakeParameter(rest);
      const std::optional<double> number = NumberOf(word);
      if (!number) {
        return Refuse(ErrorCode::kInvalidValue,
                      fmt::format("parameter {} is \"{}\", no finite number; {}",
                                  numbers_.size() + 1, Shown(word), kPostAgain),
                      word);
      }
      if (numbers_.size() == kMaxParameters) {
        return Refuse(ErrorCode::kInvalidValue, fmt::format("more than {} parameters; {}",
                                                            kMaxParameters, kPostAgain));
      }
      numbers_.push_back(*number);
    }
    if (numbers_.size() >= smallest) return true;
    return Refuse(ErrorCode::kInvalidValue,
                  fmt::format("needs {} parameters, got {}; {}", smallest,
                              numbers_.size(), kPostAgain),
                  parameters_);
  }

  /// False beyond the limit of entities, which bounds the time of a file of these alone.
  bool LeaveOut(std::string_view what, Effect effect, std::string_view remedy = {}) {
    if (!builder_.CountEntity(Place())) return false;
    builder_.LeaveOutAt(
        what, effect, [&] { return fmt::format("line {}", code_line_); }, 0, remedy);
    return true;
  }

  bool Do() {
    switch (static_cast<NciCode>(code_)) {
      case NciCode::kRapid:
      case NciCode::kLine:
        return Line();
      case NciCode::kClockwise:
      case NciCode::kCounterClockwise:
        return Arc();
      case NciCode::kFiveAxis:
        return FiveAxis();
      case NciCode::kToolPlane:
        return NoteToolPlane();
      default:
        return Other();
    }
  }

  bool Other() {
    const auto meaning = MeaningOfUndrawn(code_);
    if (meaning &&
        !LeaveOut(meaning->name, meaning->effect, "export it as lines and arcs"))
      return false;
    if (!MayMove(code_)) return true;
    if (!EndCurve()) return false;
    at_units_.reset();
    return code_ < Number(NciCode::kFirstTool) || TakeTool();
  }

  /// The fourth parameter of a tool record is the number of the tool.
  bool TakeTool() {
    if (!Numbers(4)) return false;
    const double tool = numbers_[3];
    if (tool != std::floor(tool) || std::abs(tool) > kMaxTool) {
      return Refuse(ErrorCode::kInvalidValue,
                    fmt::format("parameter 4, the number of the tool, is {}; it must be "
                                "a whole number: {}",
                                tool, kPostAgain));
    }
    layer_ = builder_.NameIndex(fmt::format("T{:.0f}", tool));
    return true;
  }

  /// The lines of another plane than the top are drawn as if they were in the top.
  bool NoteToolPlane() {
    std::size_t n = 0;
    bool top = true;
    std::string_view rest = parameters_;
    for (; n < 9 && !rest.empty(); ++n) {
      const std::optional<double> number = NumberOf(TakeParameter(rest));
      top = top && number && std::abs(*number - (n % 4 == 0 ? 1 : 0)) < 1e-6;
    }
    if (top && n == 9) return true;
    return LeaveOut("tool plane other than the top (code 1014)", Effect::kChanged,
                    "export the operations of the top plane alone");
  }

  bool CheckCompensation(double mode) {
    if (mode == 0 || mode == 40 || mode == 140) return true;
    if (mode == 41 || mode == 42) {
      return LeaveOut("cutter compensation in the control", Effect::kChanged,
                      "let the program that made the file compensate, if the path has to "
                      "be that of the tool");
    }
    return Refuse(ErrorCode::kInvalidValue,
                  fmt::format("the cutter compensation is {}; it is one of 0, 40, 41, 42 "
                              "and 140: {}",
                              mode, kPostAgain));
  }

  /// The parameters are compensation, x, y, z, feed and flags.
  bool Line() {
    if (!Numbers(6) || !CheckCompensation(numbers_[0])) return false;
    const Vec3 to(numbers_[1], numbers_[2], numbers_[3]);
    if (code_ == Number(NciCode::kRapid) || numbers_[4] == kRapidFeed) return Jump(to);
    if (!at_units_) return NoteNoBeginning(to);
    if (to.head<2>() == at_units_->head<2>()) {
      if (to.z() == at_units_->z()) return true;
      return LeaveOut("feed move along z alone (plunge or retract)",
                      Effect::kNothingSeen) &&
             Jump(to);
    }
    if (line_units_.empty()) line_units_.push_back(*at_units_);
    line_units_.push_back(to);
    at_units_ = to;
    return line_units_.size() <= limits_.max_points ||
           builder_.CountPoints(line_units_.size(), Place());
  }

  /// The parameters are plane and compensation, x and y of the end, x and y of the
  /// centre, z, feed, flags, and perhaps whether it is a full circle. Published readers
  /// differ in the order of the first two; an arc of the XY plane (0) is the same in
  /// both.
  bool Arc() {
    if (!Numbers(9)) return false;
    const double plane = std::min(numbers_[0], numbers_[1]);
    const double mode = std::max(numbers_[0], numbers_[1]);
    if (plane != 0 || mode == 1 || mode == 2) {
      return Refuse(ErrorCode::kUnsupported,
                    fmt::format("the arc is not in the XY plane (its parameters 1 and 2 "
                                "are {} and {}); export arcs of other planes as lines",
                                numbers_[0], numbers_[1]));
    }
    if (!CheckCompensation(mode)) return false;
    const Vec3 to(numbers_[2], numbers_[3], numbers_[6]);
    if (numbers_[7] == kRapidFeed) return Jump(to);
    if (!at_units_) return NoteNoBeginning(to);
    const Vec3 center(numbers_[4], numbers_[5], at_units_->z());
    const Vec3 u = *at_units_ - center;
    const Vec2 e = to.head<2>() - center.head<2>();
    const double r = u.norm(), end_r = e.norm();
    if (!(r > kSameUnits) ||
        std::abs(r - end_r) > kSameRadiusUnits + kSameRadiusRatio * r) {
      return Refuse(ErrorCode::kInvalidValue,
                    fmt::format("the arc begins {:g} and ends {:g} from its centre; both "
                                "are its radius and above 0: {}",
                                r, end_r, kPostAgain));
    }
    const double sweep = SweepTo(u, e);
    if (sweep == 0) {
      return LeaveOut("arc that ends where it begins and is no full circle",
                      Effect::kLost, kPostAgain) &&
             Jump(to);
    }
    FlushLine();
    pieces_.emplace_back(EllipticArc{center, u, Vec3(-u.y(), u.x(), 0), 0, sweep});
    const bool is_helix = std::abs(to.z() - at_units_->z()) > kSameUnits;
    at_units_ = Vec3(to.x(), to.y(), at_units_->z());
    if (3 * pieces_.size() > limits_.max_points &&
        !builder_.CountPoints(3 * pieces_.size(), Place()))
      return false;
    if (!is_helix) {
      line_units_.push_back(*at_units_);
      return true;
    }
    return LeaveOut("arc along which z changes, drawn flat at its first z",
                    Effect::kChanged, "export ramps and helices as lines") &&
           Jump(to);
  }

  /// Radians, counter-clockwise positive; 0 for an arc without a length.
  double SweepTo(const Vec3& u, const Vec2& e) const {
    const double turn = code_ == Number(NciCode::kClockwise) ? -1 : 1;
    const double r = u.head<2>().norm();
    if ((e - u.head<2>()).norm() <= kSameUnits * std::max(1.0, r))
      return numbers_.size() > 9 && numbers_[9] == 0 ? 0 : turn * 2 * pi;
    const double sweep =
        turn * std::atan2(u.x() * e.y() - u.y() * e.x(), u.head<2>().dot(e));
    return turn * (sweep > 0 ? sweep : sweep + 2 * pi);
  }

  /// The first three parameters are the place of the tool's tip.
  bool FiveAxis() {
    return Numbers(3) &&
           LeaveOut("five-axis move (code 11)", Effect::kLost,
                    "export it as three-axis moves") &&
           Jump(Vec3(numbers_[0], numbers_[1], numbers_[2]));
  }

  bool NoteNoBeginning(const Vec3& to) {
    at_units_ = to;
    return LeaveOut("feed move from a place that the file does not give", Effect::kLost,
                    "let a rapid move be before it");
  }

  bool Jump(const Vec3& to) {
    at_units_ = to;
    return EndCurve();
  }

  void FlushLine() {
    if (line_units_.size() > 1)
      pieces_.emplace_back(Polyline{std::exchange(line_units_, {})});
    line_units_.clear();
  }

  bool EndCurve() {
    FlushLine();
    if (pieces_.empty()) return true;
    if (!builder_.CountEntity(Place())) return false;
    Curve curve{std::exchange(pieces_, {}), false, layer_, 0};
    for (Piece& piece : curve.pieces)
      Transform(unit_mm_ * Mat3::Identity(), Vec3::Zero(), piece);
    return builder_.Add(std::move(curve), Place());
  }

  std::string_view text_;
  DrawingLimits limits_;
  double unit_mm_;
  DrawingBuilder builder_;
  std::size_t at_ = 0, line_ = 0, code_line_ = 0;
  std::uint32_t code_ = 0;
  std::string_view parameters_;
  std::vector<double> numbers_;
  std::uint32_t layer_ = 0;
  std::optional<Vec3> at_units_;  ///< of the tool; none: not known
  PointList line_units_;
  std::vector<Piece> pieces_;
};

}  // namespace

Result<Drawing> ReadNci(std::string_view text, const ReadOptions& options,
                        std::string_view name) {
  RequireUsable(options);
  return NciReader(text, options, name).Read();
}

}  // namespace intaglio::drawing
