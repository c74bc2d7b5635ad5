#include "engrave/contour/files/excellon_read.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>

#include "engrave/contour/files/excellon_arc.h"
#include "engrave/contour/files/excellon_numbers.h"
#include "engrave/contour/files/excellon_pattern.h"
#include "engrave/contour/files/excellon_terms.h"
#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/number_text.h"
#include "engrave/io/text_behind.h"

namespace intaglio::contour {
namespace {

constexpr int kMaxRepeats = 10'000;

class ExcellonReader {
 public:
  ExcellonReader(std::string_view text, std::string_view name,
                 const ExcellonOptions& options)
      : text_(io::WithoutByteOrderMark(text)), name_(name), options_(options) {}

  Result<DrillFile> Read() {
    if (text_.size() > options_.max_file_bytes)
      return Wrong(ErrorCode::kTooLarge,
                   fmt::format("the file has {} bytes, the limit is {}; divide it",
                               text_.size(), options_.max_file_bytes));
    if (!options_.units.empty()) {
      const auto read = options_.replace_units ? numbers_.Replace(options_.units)
                                               : numbers_.ReadUnits(options_.units);
      if (!read)
        return Fail(read.error().code, "--drill-units: " + read.error().message,
                    options_.units);
    }
    for (std::size_t at = 0; at < text_.size() && !ended_;) {
      const std::size_t end = std::min(text_.find_first_of("\r\n", at), text_.size());
      INTAGLIO_TRY(ReadLine(text_.substr(at, end - at)));
      for (std::string& what : numbers_.TakeReplaced())
        file_.findings.Add({std::move(what), fmt::format("line {}", line_number_),
                            "leave --replace-drill-units out where the file is right", 1,
                            0, Effect::kChanged});
      if (end < text_.size() && text_[end] == '\n') ++line_number_;
      if (end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] != '\n')
        ++line_number_;
      at = end + 1;
      if (ended_ && !io::TextBehind(text_, at).empty())
        (void)LeaveOut("text behind M30", "delete it, or divide the file");
    }
    if (pattern_.IsOpen())
      return Wrong(ErrorCode::kInvalidValue,
                   "a pattern begins with M25 and does not end with M01; correct it");
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

  /// With file and line, of an error without a place.
  tl::unexpected<Error> Placed(const Error& error) const {
    return Wrong(error.code, error.message, error.value);
  }
  Status Placed(const Status& done) const {
    return done ? done : Status{Placed(done.error())};
  }
  tl::unexpected<Error> NotObeyed(std::string_view command, std::string_view line) const {
    return Wrong(ErrorCode::kUnsupported,
                 fmt::format("{} would move holes and is not obeyed; export the file "
                             "without it",
                             command),
                 line);
  }

  Status ReadLine(std::string_view line) {
    while (!line.empty() && (line.back() == ' ' || line.back() == '\t'))
      line.remove_suffix(1);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t'))
      line.remove_prefix(1);
    if (line.empty() || line.front() == '/') return {};
    if (line.front() == ';') return Placed(numbers_.ReadComment(line));
    if (line == "M48") {
      known_ = in_header_ = true;
      return {};
    }
    if (line == "%" || line == "M95") {
      in_header_ = false;
      return {};
    }
    if (line.starts_with("METRIC") || line.starts_with("INCH"))
      return Placed(numbers_.ReadUnits(line));
    if (line.starts_with("ICI")) {
      incremental_ = line.find("ON") != std::string_view::npos;
      return {};
    }
    for (const char* code : {"FMAT", "VER", "DETECT", "ATC", "TCST", "M47"})
      if (line.starts_with(code)) return {};
    if (in_header_ && line.front() != 'T' && line.front() != 'M' && line.front() != 'G')
      return LeaveOut(line.substr(0, line.find(',')));
    return ReadCommand(line);
  }

  Status LeaveOut(std::string_view command, std::string remedy = "") {
    file_.findings.Add({std::string(command), fmt::format("line {}", line_number_),
                        std::move(remedy), 1, 0, Effect::kLost});
    return {};
  }

  Status ReadCommand(std::string_view line) {
    const std::vector<Term> terms = TermsOf(line);
    if (terms.empty())
      return Wrong(ErrorCode::kUnreadable,
                   "expected a command of Excellon such as T1 or X1.5Y2; the file is "
                   "damaged or of another kind",
                   line);
    switch (terms[0].letter) {
      case 'T':
        return ReadTool(terms, line);
      case 'M':
        return ReadMachineCode(terms, line);
      case 'R':
        return terms.size() > 1 && terms[1].letter == 'M' ? RepeatPattern(terms, line)
                                                          : Repeat(terms, line);
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
      const auto diameter = numbers_.Diameter(term.number);
      if (!diameter && diameter.error().code == ErrorCode::kMissing)
        return Placed(diameter.error());
      if (!diameter || !(*diameter > 0))
        return Wrong(ErrorCode::kInvalidValue,
                     "expected a positive diameter behind C; correct it", line);
      tools_[tool_] = *diameter;
    }
    return {};
  }

  Status ReadMachineCode(const std::vector<Term>& terms, std::string_view line) {
    const double code = io::ParseFinite(terms[0].number).value_or(-1);
    if (code == 71 || code == 72) {
      numbers_.SetUnit(code == 71 ? 1 : 25.4);
    } else if (code == 15) {
      down_ = true;
    } else if (code == 16 || code == 17) {
      down_ = false;
    } else if (code == 30 || code == 0) {
      ended_ = known_;
    } else if (code == 25) {
      return Placed(pattern_.Begin(file_));
    } else if (code == 1) {
      return Placed(pattern_.End(file_));
    } else if (code == 2) {
      return RepeatPattern(terms, line);
    } else if (code == 8) {
      pattern_.Finish();
    } else if (code == 70 || code == 80 || code == 90) {
      return NotObeyed(code == 70 ? "M70 (axes exchanged)" : "a mirrored image", line);
    } else if (code != 6 && code != 9) {  // stops of the operator move nothing
      return LeaveOut(line.substr(0, 1 + terms[0].number.size()));
    }
    return {};
  }

  /// M02X5.0Y0.0 or, so many times, R2M02X5.0Y0.0: the pattern again, each time farther.
  Status RepeatPattern(const std::vector<Term>& terms, std::string_view line) {
    int count = 1;
    Vec2 step = Vec2::Zero();
    for (const Term& term : terms) {
      if (term.letter == 'X' || term.letter == 'Y')
        step[term.letter == 'Y'] = INTAGLIO_TRY(Length(term.number));
      else if (term.letter == 'R')
        count = INTAGLIO_TRY(CountOf(term, line));
      else if (term.letter != 'M' || io::ParseFinite(term.number) != 2)
        return NotObeyed("a pattern that is mirrored or turned", line);
    }
    return Placed(pattern_.Repeat(count, step, options_.max_holes, file_));
  }

  Result<double> Length(std::string_view number) const {
    auto length = numbers_.Length(number);
    if (length) return length;
    return Placed(length.error());
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
    if (std::abs(axis) <= kMaxExcellon_mm) return {};
    return Wrong(ErrorCode::kInvalidValue,
                 fmt::format("a place is beyond {} mm; correct it", kMaxExcellon_mm),
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
          if (term.number == "04") return {};  // a dwell, whose X is a time
          if (term.number == "85") {
            request.slot_from = request.to;
          } else if (term.number == "92" || term.number == "93") {
            return ReadZeroSet(terms, line);
          } else {
            INTAGLIO_TRY(SetMode(term.number, line));
          }
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
          return NotObeyed(fmt::format("{}{}", term.letter, term.number), line);
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
    } else if (g == 90 || g == 91) {
      incremental_ = g == 91;
    } else if (g != 40) {  // no compensation
      return NotObeyed(fmt::format("G{}", code), line);
    }
    return {};
  }

  /// G93X0Y0: where the zero lies. Another one is taken differently by different
  /// machines.
  Status ReadZeroSet(const std::vector<Term>& terms, std::string_view line) {
    for (const Term& term : terms) {
      const bool axis = term.letter == 'X' || term.letter == 'Y';
      if (!axis && term.letter != 'G') return NotObeyed("a zero set", line);
      if (!axis) continue;
      const double length = INTAGLIO_TRY(Length(term.number));
      if (length != 0) return NotObeyed("a zero set elsewhere", line);
    }
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
    if (motion_ == 0) return {};
    if (!down_)
      return LeaveOut("route with the tool up", "M15 before it lowers the tool");
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

  Status AddArc(const Vec2& from, const Request& request) {
    auto arc = ExcellonArc(from, request.to, request.center_offset, request.radius_mm,
                           motion_ == 3);
    return arc ? AddSlot(*arc) : Placed(arc.error());
  }

  Result<int> CountOf(const Term& term, std::string_view line) const {
    const auto count = io::ParseFinite(term.number);
    if (count && *count >= 1 && *count <= kMaxRepeats && *count == std::floor(*count))
      return static_cast<int>(*count);
    return Wrong(
        ErrorCode::kInvalidValue,
        fmt::format("expected a number of repeats of 1 .. {}; correct it", kMaxRepeats),
        line);
  }

  /// R5X0.1: the last hole, five times more.
  Status Repeat(const std::vector<Term>& terms, std::string_view line) {
    const int count = INTAGLIO_TRY(CountOf(terms[0], line));
    Vec2 step = Vec2::Zero();
    for (const Term& term : terms) {
      if (term.letter == 'X' || term.letter == 'Y')
        step[term.letter == 'Y'] = INTAGLIO_TRY(Length(term.number));
    }
    const double diameter = INTAGLIO_TRY(ToolDiameter());
    for (int k = 0; k < count; ++k) {
      INTAGLIO_TRY(Count());
      place_ += step;
      if (place_.cwiseAbs().maxCoeff() > kMaxExcellon_mm)
        return Wrong(ErrorCode::kInvalidValue,
                     fmt::format("a place is beyond {} mm; correct it", kMaxExcellon_mm),
                     line);
      file_.holes.push_back({place_, diameter});
    }
    return {};
  }

  std::string_view text_;
  std::string_view name_;
  ExcellonOptions options_;
  ExcellonNumbers numbers_;
  ExcellonPattern pattern_;
  std::size_t line_number_ = 1;
  bool known_ = false, in_header_ = false, ended_ = false;
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
