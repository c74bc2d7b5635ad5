#include "engrave/post/drill_program.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"

namespace intaglio::post {
namespace {

constexpr auto kToolVariables = WithCommon(std::array<std::string_view, 1>{"TOOL"});
constexpr std::array<std::string_view, 2> kHolePlace = {"X", "Y"};
constexpr auto kHoleVariables =
    WithCommon(std::array<std::string_view, 3>{"TOOL", "X", "Y"});
constexpr FragmentRule kDrillFragments[] = {{"start", false, kToolVariables},
                                            {"cycle", true, kHoleVariables, kHolePlace},
                                            {"tool-change", false, kToolVariables},
                                            {"end", false, kToolVariables}};
constexpr SettingRule kDrillSettings[] = {kOriginX, kOriginY, kMaxBytes, kMaxName};
constexpr TemplateRules kDrillRules{kDrillFragments, kDrillSettings};
enum { kDrillStart, kDrillCycle, kDrillToolChange, kDrillEnd };

class DrillWriter {
 public:
  DrillWriter(const Template& program, const Cutting& cutting, const Vec2& origin_mm,
              std::size_t max_bytes, const HeightMap* heights)
      : program_(program),
        cutting_(cutting),
        origin_mm_(origin_mm),
        max_bytes_(max_bytes),
        heights_(heights) {
    cutting_.name = ProgramName(cutting.name);
    if (heights != nullptr) cutting_.safe_mm += std::max(0.0, heights->max_mm());
  }

  Status Add(const DrillRound& round) {
    ++tool_;
    cutting_.tool_diameter_mm = round.diameter_mm;
    if (tool_ == 1) {
      Begin();
    } else if (program_.fragments[kDrillToolChange].pieces.empty()) {
      End();
      Begin();
    } else {
      Write(kDrillToolChange);
    }
    for (const Vec2& place_mm : round.places_mm) {
      if (!Fits(place_mm)) {
        End();
        Begin();
        if (!Fits(place_mm)) return TooSmall();
      }
      Append(*expander_, kDrillCycle, place_mm, text_);
    }
    return {};
  }

  ProgramTexts Take() {
    if (tool_ > 0) End();
    return std::move(parts_);
  }

 private:
  void Begin() {
    expander_.emplace(program_, kDrillRules);
    name_ = PartName(cutting_.name, parts_.size());
    text_.clear();
    Write(kDrillStart);
  }

  void End() {
    Write(kDrillEnd);
    parts_.push_back(std::move(text_));
  }

  bool Fits(const Vec2& place_mm) const {
    Expander expander(*expander_);
    std::string text;
    Append(expander, kDrillCycle, place_mm, text);
    Append(expander, kDrillEnd, place_mm, text);
    return text_.size() + text.size() <= max_bytes_;
  }

  tl::unexpected<Error> TooSmall() const {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{}: a program of {} holds not even one hole; allow "
                            "larger ones with #max-bytes",
                            program_.file, Counted(max_bytes_, "byte")),
                fmt::format("{}", max_bytes_));
  }

  void Append(Expander& expander, std::size_t fragment, const Vec2& place_mm,
              std::string& text) const {
    const Vec2 at_mm = place_mm - origin_mm_;
    const bool is_hole = fragment == kDrillCycle;
    const double surface_mm = is_hole && heights_ != nullptr ? heights_->At(at_mm) : 0.0;
    std::vector<Value> values =
        CommonValues(cutting_, name_, cutting_.depths_mm.back() + surface_mm);
    values.emplace_back(tool_);
    if (is_hole) {
      values.emplace_back(at_mm.x());
      values.emplace_back(at_mm.y());
    }
    expander.Append(fragment, values, text);
  }

  void Write(std::size_t fragment) { Append(*expander_, fragment, Vec2::Zero(), text_); }

  const Template& program_;
  Cutting cutting_;
  Vec2 origin_mm_;
  std::size_t max_bytes_;
  const HeightMap* heights_;  // null: the surface is flat
  std::optional<Expander> expander_;
  std::string name_, text_;
  std::uint64_t tool_ = 0;
  ProgramTexts parts_;
};

}  // namespace

Result<Template> ParseDrillTemplate(std::string_view text, std::string_view file,
                                    const Parameters& given) {
  return ParseTemplate(text, file, kDrillRules, given);
}

Result<ProgramTexts> DrillPrograms(const Template& program,
                                   std::span<const DrillRound> rounds,
                                   const Cutting& cutting, const Vec2& origin_mm,
                                   std::optional<std::size_t> max_bytes,
                                   const HeightMap* heights) {
  INTAGLIO_TRY(RequireSuited(program, kDrillRules, cutting));
  const Vec2 whole_origin_mm = origin_mm + Vec2(program.SettingOf("origin-x", 0),
                                                program.SettingOf("origin-y", 0));
  const auto by_template =
      static_cast<std::size_t>(program.SettingOf("max-bytes", kMaxBytes.max));
  if (heights != nullptr) {
    if (HasOwnDepth(program)) {
      return Fail(
          ErrorCode::kUnsupported,
          program.file +
              ": has the depth of the holes itself, so they cannot follow a probed "
              "surface; choose a template that uses @DEPTH@",
          "DEPTH");
    }
    for (const DrillRound& round : rounds) {
      for (const Vec2& place_mm : round.places_mm)
        INTAGLIO_TRY(heights->RequireCovers({"a hole", place_mm, {}}, whole_origin_mm));
    }
  }
  DrillWriter writer(program, cutting, whole_origin_mm, max_bytes.value_or(by_template),
                     heights);
  for (const DrillRound& round : rounds) INTAGLIO_TRY(writer.Add(round));
  ProgramTexts texts = writer.Take();
  INTAGLIO_TRY(RequireName(program, ProgramName(cutting.name), texts.size()));
  return texts;
}

bool HasOwnDepth(const Template& program) {
  return !AnyFragmentUses(program, kDrillRules, "DEPTH");
}

}  // namespace intaglio::post
