#include "engrave/post/mill_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/post/lathe_reach.h"
#include "engrave/post/tab_parts.h"
#include "engrave/post/written_arc.h"

namespace intaglio::post {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kDefaultChordMm = 0.001;
constexpr std::size_t kMaxParts = 10'000;

constexpr std::array<std::string_view, 2> kPlace = {"X", "Y"};
constexpr std::array<std::string_view, 1> kSpeed = {"SPEED"};
constexpr std::array<std::string_view, 3> kPlaceZ = {"X", "Y", "Z"};
constexpr std::array<std::string_view, 9> kArc = {"X", "Y", "AX", "AY", "I",
                                                  "J", "R", "CR", "P"};
constexpr auto kPlaceVariables = WithCommon(kPlace);
constexpr auto kPlaceZVariables = WithCommon(kPlaceZ);
constexpr auto kArcVariables = WithCommon(kArc);
constexpr FragmentRule kMillFragments[] = {{"start", false, kCommonVariables},
                                           {"approach", true, kPlaceVariables, kPlace},
                                           {"line", true, kPlaceVariables, kPlace},
                                           {"line-z", false, kPlaceZVariables, kPlaceZ},
                                           {"speed", false, kCommonVariables, kSpeed},
                                           {"rest", false, kCommonVariables},
                                           {"arc-clockwise", false, kArcVariables},
                                           {"arc-counterclockwise", false, kArcVariables},
                                           {"retract", true, kPlaceVariables},
                                           {"end", false, kCommonVariables}};
constexpr SettingRule kMillSettings[] = {kOriginX,
                                         kOriginY,
                                         kMaxBytes,
                                         kMaxName,
                                         {"tool-radius", 0, 50},
                                         {"chord", 1e-4, 1},
                                         {"axis-x", -10000, 10000},
                                         {"axis-y", -10000, 10000},
                                         {"axis-speed", 0.01, 100000}};
constexpr TemplateRules kMillRules{kMillFragments, kMillSettings};
enum {
  kMillStart,
  kMillApproach,
  kMillLine,
  kMillLineZ,
  kMillSpeed,
  kMillRest,
  kMillClockwise,
  kMillCounterClockwise,
  kMillRetract,
  kMillEnd
};

/// Whether an arc that begins where the tool is follows from what the fragment writes.
bool Determines(const Template& program, std::size_t fragment) {
  const auto uses = [&](std::string_view variable) {
    return UsesVariable(program, kMillRules, fragment, variable);
  };
  const bool end = uses("X") && uses("Y");
  const bool center = uses("I") && uses("J");
  return (end && (center || uses("CR") || (uses("AX") && uses("AY")))) ||
         (uses("P") && (center || (end && uses("R"))));
}

constexpr auto kSpeedPlace = static_cast<std::size_t>(
    std::ranges::find(kCommonVariables, "SPEED") - kCommonVariables.begin());

bool HasOwnSpeeds(const ToolPath& path) {
  return std::ranges::any_of(
      path.moves, [](const WorkMove& move) { return move.speed_mm_s.has_value(); });
}

/// What the arcs of this template write; both directions determine the same.
ArcVariables ArcVariablesOf(const Template& program) {
  const auto uses = [&](std::string_view variable) {
    return UsesVariable(program, kMillRules, kMillClockwise, variable) ||
           UsesVariable(program, kMillRules, kMillCounterClockwise, variable);
  };
  return {uses("X") && uses("Y"), uses("I") && uses("J"), uses("AX") && uses("AY"),
          uses("P")};
}

/// Writes programs part by part.
class MillWriter {
 public:
  MillWriter(const Template& program, const Cutting& cutting, const Vec2& origin_mm,
             std::optional<std::size_t> max_bytes, const HeightMap* heights)
      : program_(program),
        cutting_(cutting),
        origin_mm_(origin_mm),
        max_bytes_(max_bytes),
        heights_(heights) {
    cutting_.name = ProgramName(cutting.name);
    if (heights != nullptr) cutting_.safe_mm += std::max(0.0, heights->max_mm());
    depth_mm_ = cutting.depths_mm.front();
    BeginPart();
  }

  Status Add(const ToolPath& path, double depth_mm) {
    depth_mm_ = depth_mm;
    rests_ = HasOwnSpeeds(path);
    if (max_bytes_ && !fresh_ && !FitsWhole(path)) INTAGLIO_TRY(EndPart());
    INTAGLIO_TRY(Approach(path));
    Vec2 at_mm = path.begin_mm;
    for (const WorkMove& move : path.moves) {
      if (!Fits(move)) {
        AppendEnd(*expander_, at_mm, text_);
        INTAGLIO_TRY(EndPart());
        speed_mm_s_ = AppendBegin(*expander_, at_mm, text_);
        if (!Fits(move)) return TooSmall(path);
      }
      speed_mm_s_ = AppendMove(*expander_, move, speed_mm_s_, text_);
      at_mm = move.end_mm;
    }
    AppendEnd(*expander_, at_mm, text_);
    fresh_ = false;
    return {};
  }

  ProgramTexts Take() {
    Write(kMillEnd);
    parts_.push_back(std::move(text_));
    return std::move(parts_);
  }

 private:
  void BeginPart() {
    expander_.emplace(program_, kMillRules);
    part_name_ = PartName(cutting_.name, parts_.size());
    text_.clear();
    Write(kMillStart);
    fresh_ = true;
  }

  Status EndPart() {
    if (parts_.size() >= kMaxParts) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("{}: more than {} programs of {} bytes; allow larger ones "
                              "with #max-bytes",
                              program_.file, kMaxParts, *max_bytes_));
    }
    Write(kMillEnd);
    parts_.push_back(std::move(text_));
    BeginPart();
    return {};
  }

  Status Approach(const ToolPath& path) {
    speed_mm_s_ = AppendBegin(*expander_, path.begin_mm, text_);
    if (path.moves.empty() || Fits(path.moves.front())) return {};
    return TooSmall(path);
  }

  tl::unexpected<Error> TooSmall(const ToolPath& path) const {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{}: a program of {} holds not even one move of {}; "
                            "allow larger ones with #max-bytes",
                            program_.file, Counted(*max_bytes_, "byte"), path.name),
                fmt::format("{}", *max_bytes_));
  }

  void Append(Expander& expander, std::size_t fragment, const WorkMove& move,
              std::string& text) const {
    const Vec2 end = move.end_mm - origin_mm_, middle = move.middle_mm - origin_mm_;
    const double z_mm = depth_mm_ + (heights_ == nullptr ? 0 : heights_->At(end));
    std::vector<Value> values =
        CommonValues(cutting_, part_name_, fragment == kMillApproach ? z_mm : depth_mm_);
    values[kSpeedPlace] = SpeedOf(move);
    if (fragment == kMillLineZ) {
      for (const double number : {end.x(), end.y(), z_mm}) values.emplace_back(number);
      return expander.Append(fragment, values, text);
    }
    const std::size_t count = kMillFragments[fragment].variables.size();
    const double signed_radius =
        move.sweep_rad > std::numbers::pi ? -move.radius_mm : move.radius_mm;
    for (const double number :
         {end.x(), end.y(), middle.x(), middle.y(), move.center_from_begin_mm.x(),
          move.center_from_begin_mm.y(), move.radius_mm, signed_radius,
          move.sweep_rad * kDegrees}) {
      if (values.size() < count) values.emplace_back(number);
    }
    expander.Append(fragment, values, text);
  }

  void AppendAt(Expander& expander, std::size_t fragment, const Vec2& at_mm,
                std::string& text) const {
    WorkMove place;
    place.end_mm = at_mm;
    Append(expander, fragment, place, text);
  }

  void Write(std::size_t fragment) {
    AppendAt(*expander_, fragment, Vec2::Zero(), text_);
  }

  std::size_t FragmentOf(const WorkMove& move) const {
    if (move.kind == WorkKind::kLine) return heights_ != nullptr ? kMillLineZ : kMillLine;
    return move.kind == WorkKind::kClockwise ? kMillClockwise : kMillCounterClockwise;
  }

  double SpeedOf(const WorkMove& move) const {
    return move.speed_mm_s.value_or(cutting_.speed_mm_s);
  }

  /// Behind moves at speed_mm_s; returns the speed then.
  double AppendMove(Expander& expander, const WorkMove& move, double speed_mm_s,
                    std::string& text) const {
    if (SpeedOf(move) != speed_mm_s) Append(expander, kMillSpeed, move, text);
    Append(expander, FragmentOf(move), move, text);
    return SpeedOf(move);
  }

  /// Down to the begin of a contour; returns the speed then.
  double AppendBegin(Expander& expander, const Vec2& at_mm, std::string& text) const {
    AppendAt(expander, kMillApproach, at_mm, text);
    if (rests_) AppendAt(expander, kMillRest, at_mm, text);
    return cutting_.speed_mm_s;
  }

  void AppendEnd(Expander& expander, const Vec2& at_mm, std::string& text) const {
    if (rests_) AppendAt(expander, kMillRest, at_mm, text);
    AppendAt(expander, kMillRetract, at_mm, text);
  }

  /// With a retract and the end of the program behind them.
  template <typename Moves>
  bool FitsWith(const Moves& add_moves) const {
    if (!max_bytes_) return true;
    Expander expander(*expander_);
    std::string text;
    const Vec2 end_mm = add_moves(expander, text);
    AppendEnd(expander, end_mm, text);
    AppendAt(expander, kMillEnd, end_mm, text);
    return text_.size() + text.size() <= *max_bytes_;
  }

  bool Fits(const WorkMove& move) const {
    return FitsWith([&](Expander& expander, std::string& text) {
      AppendMove(expander, move, speed_mm_s_, text);
      return move.end_mm;
    });
  }

  bool FitsWhole(const ToolPath& path) const {
    return FitsWith([&](Expander& expander, std::string& text) {
      Vec2 end_mm = path.begin_mm;
      double speed_mm_s = AppendBegin(expander, end_mm, text);
      for (const WorkMove& move : path.moves) {
        speed_mm_s = AppendMove(expander, move, speed_mm_s, text);
        end_mm = move.end_mm;
      }
      return end_mm;
    });
  }

  const Template& program_;
  Cutting cutting_;
  Vec2 origin_mm_;
  std::optional<std::size_t> max_bytes_;
  const HeightMap* heights_;  // null: the surface is flat
  std::optional<Expander> expander_;
  std::string part_name_;
  std::string text_;
  ProgramTexts parts_;
  double depth_mm_ = 0;
  double speed_mm_s_ = 0;  ///< of the move before
  bool rests_ = false;     ///< before and behind the contour
  bool fresh_ = true;      ///< no contour is in this part
};

Status CheckLathe(const Template& program, std::span<const ToolPath> paths,
                  const Cutting& cutting, const MillOptions& options,
                  const Vec2& origin_mm) {
  const double given = program.SettingOf("axis-speed", 0);
  const double limit_deg_s = options.axis_speed_deg_s.value_or(given);
  if (limit_deg_s <= 0) return {};
  const Vec2 axis_mm(program.SettingOf("axis-x", 0), program.SettingOf("axis-y", 0));
  return RequireReachableOnLathe(paths, axis_mm + origin_mm, cutting.speed_mm_s,
                                 limit_deg_s);
}

Status RequireLineZ(const Template& program) {
  if (!program.fragments[kMillLineZ].pieces.empty()) return {};
  return Fail(ErrorCode::kUnsupported,
              program.file +
                  ": has no fragment 'line-z', with which a tool follows a probed "
                  "surface; choose a template with it (grbl, linuxcnc), or "
                  "add one",
              "line-z");
}

}  // namespace

Result<Template> ParseMillTemplate(std::string_view text, std::string_view file,
                                   const Parameters& given) {
  Template program = INTAGLIO_TRY(ParseTemplate(text, file, kMillRules, given));
  const auto& fragments = program.fragments;
  if (fragments[kMillClockwise].pieces.empty() !=
      fragments[kMillCounterClockwise].pieces.empty()) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: fragment '{}' is given and its counterpart is not; give "
                    "both, or none to get chords",
                    file,
                    fragments[kMillClockwise].pieces.empty() ? "arc-counterclockwise"
                                                             : "arc-clockwise"));
  }
  for (const std::size_t arc : {kMillClockwise, kMillCounterClockwise}) {
    if (fragments[arc].pieces.empty() || Determines(program, arc)) continue;
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: fragment '{}' does not determine an arc; use @X@ @Y@ with @I@ "
                    "@J@, @AX@ @AY@, @CR@, or @R@ @P@, or @I@ @J@ with @P@",
                    file, kMillFragments[arc].name));
  }
  return program;
}

bool HasSpeeds(const Template& program) {
  return !program.fragments[kMillSpeed].pieces.empty() &&
         !program.fragments[kMillRest].pieces.empty();
}

Result<ProgramTexts> MillPrograms(const Template& program,
                                  std::span<const ToolPath> paths, const Cutting& cutting,
                                  const MillOptions& options) {
  INTAGLIO_TRY(RequireSuited(program, kMillRules, cutting));
  if (cutting.tab_top_mm && std::ranges::any_of(paths, HasTabs)) {
    Cutting with_tabs = cutting;
    with_tabs.depths_mm.push_back(*cutting.tab_top_mm);
    INTAGLIO_TRY(RequireSuited(program, kMillRules, with_tabs));
  }
  const Vec2 origin_mm = options.origin_mm + Vec2(program.SettingOf("origin-x", 0),
                                                  program.SettingOf("origin-y", 0));
  INTAGLIO_TRY(CheckLathe(program, paths, cutting, options, origin_mm));
  std::optional<std::size_t> max_bytes = options.max_bytes;
  if (const double given = program.SettingOf("max-bytes", 0); !max_bytes && given > 0) {
    max_bytes = static_cast<std::size_t>(given);
  }
  const HeightMap* const heights = options.heights;
  if (heights != nullptr) INTAGLIO_TRY(RequireLineZ(program));
  if (std::ranges::any_of(paths, HasOwnSpeeds) && !HasSpeeds(program)) {
    return Fail(ErrorCode::kUnsupported,
                program.file +
                    ": has no fragments 'speed' and 'rest', with which moves "
                    "have speeds of their own; choose a template with them "
                    "(grbl, grbl-laser), or add them",
                "speed");
  }
  const bool chords = options.chords || heights != nullptr ||
                      program.fragments[kMillClockwise].pieces.empty();
  const double tolerance_mm =
      options.chord_tolerance_mm.value_or(program.SettingOf("chord", kDefaultChordMm));
  const ArcVariables arcs = ArcVariablesOf(program);
  MillWriter writer(program, cutting, origin_mm, max_bytes, heights);
  for (const ToolPath& path : paths) {
    ToolPath made = chords ? Chorded(path, tolerance_mm)
                           : WritablePath(path, program, arcs, origin_mm);
    if (heights != nullptr) {
      INTAGLIO_TRY(heights->RequireCovers(made, origin_mm));
      made = heights->Divided(made, origin_mm, tolerance_mm);
    }
    for (std::size_t pass = 0; pass < cutting.depths_mm.size(); ++pass) {
      for (const PathPart& part : PartsOfPass(made, cutting, pass))
        INTAGLIO_TRY(writer.Add(part.path, part.depth_mm));
    }
  }
  ProgramTexts texts = writer.Take();
  INTAGLIO_TRY(RequireName(program, ProgramName(cutting.name), texts.size()));
  return texts;
}

}  // namespace intaglio::post
