#include "engrave/contour/files/excellon_read.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/try.h"
#include "engrave/io/number_text.h"

namespace intaglio::contour {
namespace {

constexpr double kInch_mm = 25.4;
constexpr double kMax_mm = 10'000;
constexpr int kMaxRepeats = 10'000;

bool IsOfNumber(char c) {
  return (c >= '0' && c <= '9') || c == '.' || c == '+' || c == '-';
}

/// Letters with numbers: "X1Y2" is X 1, Y 2. A letter may have none.
struct Term {
  char letter = 0;
  std::string_view number;
};

class ExcellonReader {
 public:
  ExcellonReader(std::string_view text, std::string_view name,
                 const ExcellonOptions& options)
      : text_(text),
        name_(name),
        options_(options),
        zeros_(options.zeros),
        unit_mm_(options.unit_mm) {}

  Result<DrillFile> Read() {
    if (text_.size() > options_.max_file_bytes)
      return Wrong(ErrorCode::kTooLarge,
                   fmt::format("the file has {} bytes, the limit is {}; divide it",
                               text_.size(), options_.max_file_bytes));
    for (std::size_t at = 0; at < text_.size() && !ended_;) {
      const std::size_t end = std::min(text_.find_first_of("\r\n", at), text_.size());
      INTAGLIO_TRY(ReadLine(text_.substr(at, end - at)));
      if (end < text_.size() && text_[end] == '\n') ++line_number_;
      if (end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] != '\n')
        ++line_number_;
      at = end + 1;
    }
    if (!known_)
      return Wrong(ErrorCode::kUnreadable,
                   "the file has neither a header (M48) nor a tool; it is no drill file");
    return std::move(file_);
  }

 private:
  tl::unexpected<Error> Wrong(ErrorCode code, const std::string& sentence,
                              std::string_view value = {}) const {
    return Fail(code, fmt::format("{}: line {}: {}", name_, line_number_, sentence),
                std::string(value.substr(0, 80)));
  }

  Status ReadLine(std::string_view line) {
    while (!line.empty() && (line.back() == ' ' || line.back() == '\t'))
      line.remove_suffix(1);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t'))
      line.remove_prefix(1);
    if (line.empty() || line.front() == ';' || line.front() == '/') return {};
    if (line == "M48") {
      known_ = in_header_ = true;
      return {};
    }
    if (line == "%" || line == "M95") {
      in_header_ = false;
      return {};
    }
    if (line.starts_with("METRIC") || line.starts_with("INCH")) return ReadUnits(line);
    if (line.starts_with("ICI")) {
      incremental_ = line.find("ON") != std::string_view::npos;
      return {};
    }
    if (line.starts_with("M47")) return LeaveOut("M47");
    if (in_header_ && line.front() != 'T' && line.front() != 'M' && line.front() != 'G')
      return LeaveOut(line.substr(0, line.find(',')));
    if (line.starts_with("TCST")) return LeaveOut("TCST");
    return ReadCommand(line);
  }

  Status LeaveOut(std::string_view command) {
    ++file_.left_out[std::string(command.substr(0, 16))];
    return {};
  }

  /// METRIC or INCH, then LZ, TZ or digits as 000.000, in any order.
  Status ReadUnits(std::string_view line) {
    unit_mm_ = line.front() == 'M' ? 1 : kInch_mm;
    for (std::size_t comma = line.find(','); comma != std::string_view::npos;
         comma = line.find(',', comma + 1)) {
      const std::size_t end = line.find(',', comma + 1);
      const std::string_view field = line.substr(comma + 1, end - comma - 1);
      const std::size_t point = field.find('.');
      if (field == "LZ" || field == "TZ") {
        zeros_ = field == "LZ" ? Zeros::kLeading : Zeros::kTrailing;
      } else if (point != std::string_view::npos && field.size() <= 12 &&
                 field.find_first_not_of("0.") == std::string_view::npos) {
        digits_ = {static_cast<int>(point), static_cast<int>(field.size() - point) - 1};
      } else {
        return Wrong(ErrorCode::kUnreadable,
                     "expected LZ, TZ or digits such as 000.000; correct the header",
                     field);
      }
    }
    return {};
  }

  Status ReadCommand(std::string_view line) {
    std::vector<Term> terms;
    for (std::size_t at = 0; at < line.size();) {
      Term term{line[at], {}};
      std::size_t end = ++at;
      while (end < line.size() && IsOfNumber(line[end])) ++end;
      term.number = line.substr(at, end - at);
      if (term.letter < 'A' || term.letter > 'Z' || terms.size() == 16)
        return Wrong(ErrorCode::kUnreadable,
                     "expected a command of Excellon such as T1 or X1.5Y2; the file is "
                     "damaged or of another kind",
                     line);
      terms.push_back(term);
      at = end;
    }
    switch (terms[0].letter) {
      case 'T':
        return ReadTool(terms, line);
      case 'M':
        return ReadMachineCode(terms[0], line);
      case 'R':
        return Repeat(terms, line);
      default:
        return ReadMove(terms, line);
    }
  }

  /// T1C0.8 defines (with feeds F, speeds S, B, H, Z), T1 selects, T0 puts away.
  Status ReadTool(const std::vector<Term>& terms, std::string_view line) {
    const auto number = io::ParseFinite(terms[0].number);
    if (!number || *number < 0 || *number > 9999 || *number != std::floor(*number))
      return Wrong(ErrorCode::kInvalidValue, "expected the number of a tool; correct it",
                   line);
    known_ = true;
    tool_ = static_cast<int>(*number);
    for (const Term& term : terms) {
      if (term.letter != 'C') continue;
      if (!unit_mm_) return UnitsMissing();
      const auto diameter = io::ParseFinite(term.number);
      if (!diameter || !(*diameter > 0) || *diameter * *unit_mm_ > kMax_mm)
        return Wrong(ErrorCode::kInvalidValue,
                     "expected a positive diameter behind C; correct it", line);
      tools_[tool_] = *diameter * *unit_mm_;
    }
    return {};
  }

  Status ReadMachineCode(const Term& term, std::string_view line) {
    if (term.number == "71" || term.number == "72") {
      unit_mm_ = term.number == "71" ? 1 : kInch_mm;
    } else if (term.number == "15") {
      down_ = true;
    } else if (term.number == "16" || term.number == "17") {
      down_ = false;
    } else if (term.number == "30" || term.number == "00" || term.number == "0") {
      ended_ = known_;
    } else {
      return LeaveOut(line);
    }
    return {};
  }

  tl::unexpected<Error> UnitsMissing() const {
    return Wrong(
        ErrorCode::kMissing,
        "the file declares neither METRIC nor INCH before it has a length; export "
        "it with units, or give the unit");
  }

  Result<double> Length(std::string_view number) const {
    if (!unit_mm_) return UnitsMissing();
    auto value = io::ParseFinite(number);
    if (value && number.find('.') == std::string_view::npos) {
      if (!zeros_)
        return Wrong(
            ErrorCode::kMissing,
            "a coordinate has no decimal point and the header declares neither LZ "
            "nor TZ; export with decimal points, or give which zeros are left out",
            number);
      const auto [before, behind] = Digits();
      const bool sign = number.front() == '-' || number.front() == '+';
      const int count = static_cast<int>(number.size()) - (sign ? 1 : 0);
      const int shift = *zeros_ == Zeros::kLeading ? count - before : behind;
      value = *value * std::pow(10, -shift);
    }
    if (value && std::abs(*value * *unit_mm_) <= kMax_mm) return *value * *unit_mm_;
    return Wrong(ErrorCode::kInvalidValue,
                 fmt::format("expected a length of at most {} mm; correct it", kMax_mm),
                 number);
  }
  std::pair<int, int> Digits() const {
    if (digits_.first + digits_.second > 0) return digits_;
    return *unit_mm_ == 1 ? std::pair(3, 3) : std::pair(2, 4);
  }

  Result<double> ToolDiameter() const {
    const auto found = tools_.find(tool_);
    if (found != tools_.end()) return found->second;
    return Wrong(ErrorCode::kMissing,
                 tool_ < 0 ? std::string("a hole before any tool; select one")
                           : fmt::format("tool T{} has no diameter; define it in the "
                                         "header, such as T{}C0.8",
                                         tool_, tool_));
  }

  /// X and Y of these terms; what is not given stays.
  Status Move(const Term& term, Vec2& place) const {
    double& axis = term.letter == 'X' ? place.x() : place.y();
    const double length = INTAGLIO_TRY(Length(term.number));
    axis = incremental_ ? axis + length : length;
    if (std::abs(axis) <= kMax_mm) return {};
    return Wrong(ErrorCode::kInvalidValue,
                 fmt::format("a place is beyond {} mm; correct it", kMax_mm),
                 term.number);
  }

  /// What a line with coordinates asks for.
  struct Request {
    Vec2 to = Vec2::Zero();
    std::optional<Vec2> slot_from;
    std::optional<double> radius_mm;
    std::optional<Vec2> center_offset;
    bool moves = false;
  };

  Status ReadMove(const std::vector<Term>& terms, std::string_view line) {
    Request request{place_, {}, {}, {}, false};
    for (const Term& term : terms) {
      switch (term.letter) {
        case 'X':
        case 'Y':
          INTAGLIO_TRY(Move(term, request.to));
          request.moves = true;
          break;
        case 'G':
          if (term.number == "85")
            request.slot_from = request.to;
          else
            INTAGLIO_TRY(SetMode(term.number, line));
          break;
        case 'A':
          request.radius_mm = INTAGLIO_TRY(Length(term.number));
          break;
        case 'I':
        case 'J': {
          if (!request.center_offset) request.center_offset = Vec2::Zero();
          (*request.center_offset)[term.letter == 'J'] =
              INTAGLIO_TRY(Length(term.number));
          break;
        }
        case 'F':
        case 'S':
          break;
        default:
          return LeaveOut(line);
      }
    }
    return request.moves ? Execute(request) : Status{};
  }

  Status SetMode(std::string_view code, std::string_view line) {
    const auto number = io::ParseFinite(code);
    const double g = number.value_or(-1);
    if (g == 5 || g == 81)
      routing_ = false;
    else if (g == 0 || g == 1 || g == 2 || g == 3) {
      routing_ = true;
      motion_ = static_cast<int>(g);
    } else if (g == 90 || g == 91)
      incremental_ = g == 91;
    else
      return LeaveOut(line);
    return {};
  }

  Status Count() {
    if (file_.holes.size() + file_.slots.size() < options_.max_holes) return {};
    return Wrong(ErrorCode::kTooLarge,
                 fmt::format("more than {} holes; divide the file", options_.max_holes));
  }

  Status Execute(const Request& request) {
    const Vec2 from = place_;
    place_ = request.to;
    if (request.slot_from) return AddSlot(MakeLine(*request.slot_from, request.to));
    if (!routing_) {
      const double diameter = INTAGLIO_TRY(ToolDiameter());
      INTAGLIO_TRY(Count());
      file_.holes.push_back({place_, diameter});
      return {};
    }
    if (motion_ == 0 || !down_) return {};
    if (motion_ == 1) return AddSlot(MakeLine(from, place_));
    return AddArc(from, request);
  }

  Status AddSlot(const Edge& edge) {
    const double width = INTAGLIO_TRY(ToolDiameter());
    INTAGLIO_TRY(Count());
    if (edge.is_arc())
      file_.slots.push_back({ArcTrack{edge, width}, {}});
    else
      file_.slots.push_back({Track{edge.begin_mm, edge.end_mm, width}, {}});
    return {};
  }

  /// With a radius the shorter of the two arcs.
  Status AddArc(const Vec2& from, const Request& request) {
    const bool left = motion_ == 3;
    const Vec2 chord = request.to - from;
    const double half = chord.norm() / 2;
    Vec2 center = Vec2::Zero();
    if (request.center_offset) {
      center = from + *request.center_offset;
    } else if (request.radius_mm && half > 0 && *request.radius_mm >= half * (1 - 1e-6)) {
      const double r = *request.radius_mm;
      const double off = std::sqrt(std::max(0.0, r * r - half * half));
      center = from + chord / 2 + RightOf(chord.normalized()) * (left ? -off : off);
    } else {
      return Wrong(ErrorCode::kUnsupported,
                   "an arc needs its radius A, at least half its chord, or I and J; "
                   "export it again");
    }
    const double r = (from - center).norm();
    if (r < 1e-6 || std::abs((request.to - center).norm() - r) > 0.01 + 1e-3 * r)
      return Wrong(ErrorCode::kUnsupported,
                   "the ends of an arc are not equally far from its centre; export it "
                   "again");
    return AddSlot(MakeArcBetween(from, request.to, center, left));
  }

  /// R5X0.1: the last hole, five times more.
  Status Repeat(const std::vector<Term>& terms, std::string_view line) {
    const auto count = io::ParseFinite(terms[0].number);
    if (!count || *count < 1 || *count > kMaxRepeats || *count != std::floor(*count))
      return Wrong(
          ErrorCode::kInvalidValue,
          fmt::format("expected a number of repeats of 1 .. {}; correct it", kMaxRepeats),
          line);
    Vec2 step = Vec2::Zero();
    for (const Term& term : terms) {
      if (term.letter == 'X' || term.letter == 'Y')
        step[term.letter == 'Y'] = INTAGLIO_TRY(Length(term.number));
    }
    const double diameter = INTAGLIO_TRY(ToolDiameter());
    for (int k = 0; k < static_cast<int>(*count); ++k) {
      INTAGLIO_TRY(Count());
      place_ += step;
      if (place_.cwiseAbs().maxCoeff() > kMax_mm)
        return Wrong(ErrorCode::kInvalidValue,
                     fmt::format("a place is beyond {} mm; correct it", kMax_mm), line);
      file_.holes.push_back({place_, diameter});
    }
    return {};
  }

  std::string_view text_;
  std::string_view name_;
  ExcellonOptions options_;
  std::optional<Zeros> zeros_;
  std::optional<double> unit_mm_;
  std::pair<int, int> digits_{0, 0};  ///< before and behind the point; 0, 0: by the unit
  std::size_t line_number_ = 1;
  bool known_ = false;
  bool in_header_ = false;
  bool ended_ = false;
  bool incremental_ = false;
  bool routing_ = false;
  bool down_ = false;
  int motion_ = 0;
  int tool_ = -1;
  std::map<int, double> tools_;
  Vec2 place_ = Vec2::Zero();
  DrillFile file_;
};

}  // namespace

Result<DrillFile> ReadExcellon(std::string_view text, std::string_view name,
                               const ExcellonOptions& options) {
  return ExcellonReader(text, name, options).Read();
}

}  // namespace intaglio::contour
