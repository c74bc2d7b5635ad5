#include "engrave/contour/files/gerber_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engrave/contour/files/gerber_aperture.h"
#include "engrave/contour/files/gerber_objects.h"
#include "engrave/contour/files/gerber_parameters.h"
#include "engrave/contour/files/gerber_region.h"
#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/number_text.h"
#include "engrave/io/text_behind.h"

namespace intaglio::contour {
namespace {

constexpr double kMaxPlace_mm = 10'000;
constexpr std::size_t kMaxWithoutUnit = 10'000;
constexpr std::string_view kBlanks = " \t\r\n";

class GerberReader {
 public:
  GerberReader(std::string_view text, std::string_view name, const GerberLimits& limits)
      : text_(text), name_(name), limits_(limits), objects_(limits) {}

  Result<std::vector<Element>> Read() {
    if (text_.size() > limits_.max_file_bytes)
      return Wrong(ErrorCode::kTooLarge,
                   fmt::format("the file has {} bytes, the limit is {}; divide it",
                               text_.size(), limits_.max_file_bytes));
    while (!ended_) {
      SkipBlanks();
      if (at_ == text_.size())
        return Wrong(ErrorCode::kMissing,
                     "the file does not end with M02; it is cut short or no Gerber file");
      if (text_[at_] == '%') {
        INTAGLIO_TRY(ReadExtended());
        continue;
      }
      const std::string block = INTAGLIO_TRY(Block());
      INTAGLIO_TRY(ReadCommand(block));
    }
    auto elements = objects_.Finish();
    if (!elements) return Wrong(elements.error(), "LPC");
    return elements;
  }

 private:
  tl::unexpected<Error> Wrong(ErrorCode code, const std::string& sentence,
                              std::string_view value = {}) const {
    return Fail(code, fmt::format("{}: line {}: {}", name_, line_number_, sentence),
                std::string(value.substr(0, 80)));
  }
  tl::unexpected<Error> Wrong(const Error& error, std::string_view value) const {
    return Wrong(error.code, error.message + "; export the layer again", value);
  }
  tl::unexpected<Error> NotRead(std::string_view block, const char* what) const {
    return Wrong(
        ErrorCode::kUnsupported,
        fmt::format("{} would change the copper and is not read; export the layer "
                    "without it",
                    what),
        block);
  }

  void SkipBlanks() {
    for (; at_ < text_.size() && kBlanks.find(text_[at_]) != kBlanks.npos; ++at_)
      line_number_ += text_[at_] == '\n' ? 1 : 0;
  }

  /// Up to '*', without line breaks. A comment may have '%', which some programs write.
  Result<std::string> Block() {
    std::string block;
    const auto ends = [&](char c) {
      return c == '*' || (c == '%' && !block.starts_with("G04"));
    };
    for (; at_ < text_.size() && !ends(text_[at_]); ++at_) {
      if (text_[at_] == '\n') ++line_number_;
      if (text_[at_] != '\n' && text_[at_] != '\r') block += text_[at_];
    }
    if (at_ == text_.size() || text_[at_] != '*')
      return Wrong(ErrorCode::kUnreadable,
                   "a command does not end with '*'; the file is damaged or of another "
                   "kind",
                   block);
    ++at_;
    return block;
  }

  Status ReadExtended() {
    ++at_;
    std::vector<std::string> blocks;
    for (;;) {
      SkipBlanks();
      if (at_ < text_.size() && text_[at_] == '%') break;
      blocks.push_back(INTAGLIO_TRY(Block()));
    }
    ++at_;
    if (!blocks.empty() && blocks[0].starts_with("AM")) {
      macros_[blocks[0].substr(2)] = {blocks.begin() + 1, blocks.end()};
      return {};
    }
    for (const std::string& block : blocks) INTAGLIO_TRY(ReadParameter(block));
    return {};
  }

  Status ReadParameter(const std::string& block) {
    auto read = Parameter(block);
    if (read) return {};
    if (read.error().code == ErrorCode::kUnsupported && read.error().message.empty())
      return NotRead(block, block.substr(0, 16).c_str());
    return Wrong(read.error(), block);
  }

  /// Errors without a place.
  Status Parameter(const std::string& block) {
    const std::string code = block.substr(0, 2);
    if (code == "FS") {
      format_ = INTAGLIO_TRY(ParseGerberFormat(block));
    } else if (code == "MO") {
      unit_mm_ = INTAGLIO_TRY(ParseGerberUnit(block));
      for (const std::string& earlier : std::exchange(without_unit_, {}))
        INTAGLIO_TRY(AddAperture(earlier));
    } else if (code == "AD") {
      if (unit_mm_ || without_unit_.size() == kMaxWithoutUnit) return AddAperture(block);
      without_unit_.push_back(block);
    } else if (code == "SR") {
      const double unit = INTAGLIO_TRY(Unit());
      const GerberRepeat repeat = INTAGLIO_TRY(ParseGerberRepeat(block, unit));
      return objects_.Repeat(repeat);
    } else if (block == "LPC" || block == "LPD") {
      objects_.SetClear(block == "LPC");
    } else if (code == "TO" || code == "TD") {
      ReadName(block);
    } else if (!HasNoEffect(block)) {
      return Fail(ErrorCode::kUnsupported, "");
    }
    return {};
  }

  Status AddAperture(const std::string& block) {
    if (!unit_mm_) return tl::unexpected(Unit().error());
    auto [number, aperture] =
        INTAGLIO_TRY(ParseGerberAperture(block, macros_, *unit_mm_));
    apertures_[number] = std::move(aperture);
    return {};
  }

  Result<double> Unit() const {
    if (unit_mm_ && format_.digits > 0) return *unit_mm_;
    return Wrong(
        ErrorCode::kMissing,
        "a length before the format (FS) and the unit (MO); the file is damaged");
  }

  /// TO.P,R1,2 names a pin, TO.N,GND a net; the pin's name goes first.
  void ReadName(const std::string& block) {
    if (block.starts_with("TD")) {
      name_of_element_.clear();
      net_.clear();
      named_by_pin_ = false;
      return;
    }
    const bool pin = block.starts_with("TO.P,");
    // "N/C" is the net of what is connected to nothing else (Ucamco 2022, ch. 5.6.14).
    if (block.starts_with("TO.N,")) net_ = block == "TO.N,N/C" ? "" : block.substr(5);
    if (!pin && (!block.starts_with("TO.N,") || named_by_pin_)) return;
    name_of_element_ = block.substr(5, 64);
    named_by_pin_ = pin;
    if (pin) std::replace(name_of_element_.begin(), name_of_element_.end(), ',', '-');
  }

  /// Layers that were joined into one file; a comment may stand there.
  Status CheckBehindEnd() const {
    if (io::TextBehind(text_, at_).find_first_of("XY%") == text_.npos) return {};
    return Wrong(ErrorCode::kUnsupported,
                 "there is more behind the end (M02); divide the file, or delete it");
  }

  Status ReadCommand(std::string_view block) {
    if (block.empty() || block.starts_with("G04") || block.starts_with("G4 ")) return {};
    if (block == "M02" || block == "M2" || block == "M00") {
      ended_ = true;
      if (region_) return Wrong(ErrorCode::kInvalidValue, "a region does not end (G37)");
      return CheckBehindEnd();
    }
    Vec2 offset = Vec2::Zero();
    Vec2 to = place_;
    bool moves = false;
    std::optional<int> operation;
    for (std::size_t begin = 0; begin < block.size();) {
      const char letter = block[begin];
      std::size_t end = begin + 1;
      while (end < block.size() && (block[end] < 'A' || block[end] > 'Z')) ++end;
      const std::string_view number = block.substr(begin + 1, end - begin - 1);
      begin = end;
      if (letter == 'X' || letter == 'Y') {
        to[letter == 'Y'] = INTAGLIO_TRY(Length(number));
        moves = true;
      } else if (letter == 'I' || letter == 'J') {
        offset[letter == 'J'] = INTAGLIO_TRY(Length(number));
      } else if (letter == 'G') {
        INTAGLIO_TRY(SetMode(number, block));
      } else if (letter == 'D') {
        const int code = INTAGLIO_TRY(CodeIn(number, block));
        if (code >= 10)
          INTAGLIO_TRY(Select(code));
        else
          operation = code;
      } else {
        return Wrong(
            ErrorCode::kUnreadable,
            "expected a command such as X1000Y2000D01 or G01; the file is damaged "
            "or of another kind",
            block);
      }
    }
    if (!operation && !moves) return {};
    if (operation) operation_ = *operation;
    return Operate(to, offset, block);
  }

  Result<int> CodeIn(std::string_view number, std::string_view block) const {
    const auto value = io::ParseFinite(number);
    if (value && *value >= 0 && *value <= 1e6 && *value == std::floor(*value))
      return static_cast<int>(*value);
    return Wrong(ErrorCode::kUnreadable, "expected a whole number behind a letter",
                 block);
  }

  Result<double> Length(std::string_view number) const {
    const double unit = INTAGLIO_TRY(Unit());
    const auto value = io::ParseFinite(number);
    const int sign = number.starts_with('-') || number.starts_with('+') ? 1 : 0;
    const int count = static_cast<int>(number.size()) - sign;
    const int behind = format_.trailing_left_out
                           ? count - (format_.digits - format_.behind)
                           : format_.behind;
    const double length = value.value_or(1e300) * std::pow(10, -behind) * unit;
    if (number.find_first_of(".eE") == std::string_view::npos && count <= 15 &&
        std::abs(length) <= kMaxPlace_mm)
      return length;
    return Wrong(
        ErrorCode::kInvalidValue,
        fmt::format("expected a length without a point of at most {} mm", kMaxPlace_mm),
        number);
  }

  Status SetMode(std::string_view number, std::string_view block) {
    const int code = INTAGLIO_TRY(CodeIn(number, block));
    switch (code) {
      case 1:
      case 2:
      case 3:
        motion_ = code;
        return {};
      case 36:
        region_ = Edges{};
        return {};
      case 37:
        INTAGLIO_TRY(EndPath());
        region_.reset();
        return {};
      case 70:
      case 71:
        unit_mm_ = code == 70 ? 25.4 : 1;
        return {};
      case 74:
        single_quadrant_ = true;
        return {};
      case 75:
        single_quadrant_ = false;
        return {};
      default:
        return code == 54 || code == 55 || code == 90 ? Status{}
                                                      : NotRead(block, "this G code");
    }
  }

  Status Select(int code) {
    const auto found = apertures_.find(code);
    if (found == apertures_.end())
      return Wrong(
          ErrorCode::kMissing,
          fmt::format("aperture D{} is not defined; export the layer again", code));
    aperture_ = &found->second;
    return {};
  }

  Status Operate(const Vec2& to, const Vec2& offset, std::string_view block) {
    const Vec2 from = place_;
    place_ = to;
    if (operation_ == 2) return region_ ? EndPath() : Status{};
    if (operation_ != 1 && operation_ != 3)
      return Wrong(ErrorCode::kUnreadable, "a place without D01, D02 or D03", block);
    if (operation_ == 3) {
      if (region_) return Wrong(ErrorCode::kInvalidValue, "a flash in a region", block);
      return Flash();
    }
    const bool arc = motion_ != 1;
    if (arc && single_quadrant_)
      return NotRead(block, "an arc of a single quadrant (G74)");
    Edge edge = MakeLine(from, to);
    if (arc) edge = INTAGLIO_TRY(ArcTo(from, to, from + offset, block));
    if (!region_) return Draw(edge, block);
    if (++edge_count_ > limits_.max_edges) return TooMany();
    region_->push_back(edge);
    return {};
  }

  /// The centre is moved to where both ends are equally far: files round all three.
  Result<Edge> ArcTo(const Vec2& from, const Vec2& to, Vec2 center,
                     std::string_view block) const {
    const double r = (from - center).norm();
    const double digit_mm = std::pow(10, -format_.behind) * unit_mm_.value_or(0);
    if (r < 1e-6 || std::abs((to - center).norm() - r) > 0.01 + 0.01 * r + 2 * digit_mm)
      return Wrong(ErrorCode::kInvalidValue,
                   "the ends of an arc are not equally far from its centre; export the "
                   "layer again",
                   block);
    if (from != to) {
      const Vec2 along = (to - from).normalized();
      center += along * along.dot(0.5 * (from + to) - center);
      if ((from - center).norm() < 1e-6) return MakeLine(from, to);
    }
    return MakeArcBetween(from, to, center, motion_ == 3);
  }

  Status CheckAperture() const {
    if (aperture_) return {};
    return Wrong(ErrorCode::kMissing, "no aperture is selected; export the layer again");
  }
  Status Flash() {
    INTAGLIO_TRY(CheckAperture());
    for (const Shape& shape : aperture_->shapes) INTAGLIO_TRY(Add(Moved(shape, place_)));
    return {};
  }

  Status Draw(const Edge& edge, std::string_view block) {
    INTAGLIO_TRY(CheckAperture());
    const double width = aperture_->draw_width_mm;
    if (width == 0) return {};  // the specification's "no image"
    if (width > 0 && edge.is_arc()) return Add(ArcTrack{edge, width});
    if (width > 0) return Add(Track{edge.begin_mm, edge.end_mm, width});
    if (aperture_->draw_box_mm.x() > 0 && !edge.is_arc())
      return Add(SweptBox(aperture_->draw_box_mm, edge.begin_mm, edge.end_mm));
    return NotRead(block, "a draw with this aperture");
  }

  Status EndPath() {
    if (!region_ || region_->empty()) return {};
    const Edges path = std::exchange(*region_, {});
    auto outline = RegionOutline(path);
    if (!outline) return Wrong(outline.error(), "G36");
    // Layout programs write slivers without an area.
    return outline->loops.empty() ? Status{} : Add(std::move(*outline));
  }
  tl::unexpected<Error> TooMany() const { return Wrong(objects_.TooMany(), {}); }
  Status Add(Shape shape) {
    auto added = objects_.Add({std::move(shape), name_of_element_, net_});
    return added ? Status{} : Wrong(added.error(), {});
  }

  std::string_view text_;
  std::string_view name_;
  GerberLimits limits_;
  std::size_t at_ = 0;
  std::size_t line_number_ = 1;
  bool ended_ = false;
  GerberFormat format_;
  std::optional<double> unit_mm_;
  GerberMacros macros_;
  std::vector<std::string> without_unit_;  ///< apertures before the unit
  std::map<int, GerberAperture> apertures_;
  const GerberAperture* aperture_ = nullptr;
  Vec2 place_ = Vec2::Zero();
  int motion_ = 1;
  int operation_ = 0;
  bool single_quadrant_ = false;
  std::optional<Edges> region_;
  std::string name_of_element_;
  std::string net_;
  bool named_by_pin_ = false;
  std::uint64_t edge_count_ = 0;  ///< of regions
  GerberObjects objects_;
};

}  // namespace

Result<std::vector<Element>> ReadGerber(std::string_view text, std::string_view name,
                                        const GerberLimits& limits) {
  return GerberReader(io::WithoutByteOrderMark(text), name, limits).Read();
}

}  // namespace intaglio::contour
