#include "engrave/drawing/dxf/dxf_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "engrave/drawing/clip.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/dxf/dxf_blocks.h"
#include "engrave/drawing/dxf/dxf_curves.h"
#include "engrave/drawing/dxf/dxf_encoding.h"
#include "engrave/drawing/dxf/dxf_hatch.h"
#include "engrave/drawing/dxf/dxf_insert.h"
#include "engrave/drawing/dxf/dxf_layers.h"
#include "engrave/drawing/dxf/dxf_text.h"
#include "engrave/drawing/dxf/dxf_xclip.h"
#include "engrave/drawing/pieces.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/dxf_unit.h"
#include "engrave/io/lower_case.h"
#include "engrave/io/text_behind.h"

namespace intaglio::drawing {
namespace {

/// The place of entities: the drawing, or a block that is inserted.
struct BlockContext {
  DxfAffine place;
  std::vector<std::string> blocks;  ///< names, from the outermost to the innermost
  std::string_view layer;           ///< of the insertion; entities on layer "0" are
                                    ///< on it
  std::vector<std::shared_ptr<const ClipArea>> clips;  ///< of all these blocks
};

class DxfReader {
 public:
  DxfReader(std::string_view text, const ReadOptions& options, std::string_view name)
      : text_(text), options_(options), builder_(name, options.limits) {}

  Result<Drawing> Read() {
    if (CheckKind() && ReadSections()) {
      BlockContext in_drawing;
      in_drawing.place.linear *= options_.unit_mm.value_or(unit_mm_);
      for (const DxfText& section : entities_) {
        if (!Unfold(section, in_drawing)) break;
      }
    }
    builder_.SetUnit(options_.unit_mm.value_or(unit_mm_));
    return builder_.Take();
  }

 private:
  bool CheckKind() {
    if (!builder_.CheckSize(text_.size())) return false;
    text_ = io::WithoutByteOrderMark(text_);
    if (IsBinaryDxf(text_)) {
      auto text = TextOfBinaryDxf(text_, 2 * options_.limits.max_file_bytes);
      if (!text) return builder_.Refuse(text.error().code, "", text.error().message);
      decoded_ = std::move(*text);
      text_ = decoded_;
    }
    if (text_.starts_with("AC10")) {
      return builder_.Refuse(ErrorCode::kUnsupported, "",
                             "the file is a DWG; save it as DXF in text form");
    }
    return Decode();
  }

  /// Decodes files whose names and texts are in a code page.
  bool Decode() {
    std::string code_page;
    auto utf8 = DxfInUtf8(text_, code_page);
    if (!utf8) {
      builder_.LeaveOut(fmt::format("code page {:?}", code_page), Effect::kChanged,
                        "$DWGCODEPAGE");
    } else if (!utf8->empty()) {
      decoded_ = std::move(*utf8);
      text_ = decoded_;
    }
    return true;
  }

  /// Records the positions of sections and blocks, and the unit.
  bool ReadSections() {
    DxfGroups groups({text_, 1}, builder_);
    DxfGroup group;
    bool any = false;
    while (groups.Next(group)) {
      if (group.code != 0) continue;
      if (group.value == "EOF") {
        NoteBehindEnd(groups);
        break;
      }
      if (group.value != "SECTION") continue;
      any = true;
      if (!groups.Next(group)) {
        return builder_.Refuse(ErrorCode::kUnreadable, "",
                               "the file ends at a SECTION; it is truncated, copy it "
                               "again");
      }
      if (!ReadSection(group.value, groups)) return false;
    }
    if (!groups.good()) return false;
    return any || builder_.Refuse(ErrorCode::kUnreadable, "",
                                  "the file has no SECTION; it is not DXF");
  }

  void NoteBehindEnd(DxfGroups& groups) {
    if (io::TextBehind(text_, groups.position()).empty()) return;
    builder_.LeaveOut("text behind EOF", Effect::kLost,
                      fmt::format("line {}", groups.line()), 0,
                      "delete it, or divide the file");
  }

  bool ReadSection(std::string_view section, DxfGroups& groups) {
    const std::uint64_t first_line = groups.line();
    const std::size_t begin = groups.position();
    std::size_t end = begin;
    DxfGroup group;
    std::string_view variable;
    while (groups.Next(group)) {
      if (group.code == 0 && group.value == "ENDSEC") {
        const DxfText text{groups.From(begin, end), first_line};
        if (section == "ENTITIES") entities_.push_back(text);
        if (section == "TABLES") return layers_.Read(text, builder_);
        if (section == "OBJECTS") return xclips_.Read(text, builder_);
        return section != "BLOCKS" || blocks_.Read(text, builder_);
      }
      if (group.code == 9) variable = group.value;
      if (section == "HEADER" && group.code == 70 && variable == "$INSUNITS" &&
          !TakeUnit(group)) {
        return false;
      }
      end = groups.position();
    }
    return builder_.Refuse(
        ErrorCode::kUnreadable, fmt::format("line {}", groups.line()),
        fmt::format("the file ends within section {}; it is truncated, copy it again",
                    Shown(section)));
  }

  bool TakeUnit(const DxfGroup& group) {
    const std::optional<double> unit_mm = io::DxfUnitMm(group.value);
    if (options_.unit_mm) {
      if (unit_mm && io::DxfUnitMm("0") != unit_mm && *unit_mm != *options_.unit_mm)
        builder_.LeaveOut(fmt::format("$INSUNITS ({:g} mm; {:g} mm as asked for)",
                                      *unit_mm, *options_.unit_mm),
                          Effect::kNothingSeen, fmt::format("line {}", group.line + 1));
      return true;
    }
    if (!unit_mm) {
      return builder_.Refuse(ErrorCode::kUnsupported,
                             fmt::format("line {}", group.line + 1),
                             "$INSUNITS is not a known unit of length (0 to 24); give "
                             "the length of a unit in mm",
                             group.value);
    }
    unit_mm_ = *unit_mm;
    return true;
  }

  bool Unfold(const DxfText& text, const BlockContext& in) {
    DxfEntities entities(text, builder_);
    DxfEntity entity;
    while (entities.Next(entity)) {
      if (entity.type == "INSERT") {
        if (!UnfoldInsert(entity, in)) return false;
      } else if (entity.type == "HATCH") {
        if (!AddHatch(entity, in)) return false;
      } else if (options_.text_font && IsDxfText(entity.type)) {
        if (!AddText(entity, in)) return false;
      } else if (!IsDxfCurve(entity.type)) {
        LeaveOut(entity);
      } else if (!AddCurve(entity, in)) {
        return false;
      }
    }
    return entities.good();
  }

  void LeaveOut(const DxfEntity& entity) {
    // What closes others, a view of a sheet, lines without an end for constructions.
    constexpr std::string_view kNoLines[] = {"VIEWPORT", "XLINE", "RAY", "ATTDEF"};
    if (entity.type == "SEQEND") return;
    const bool seen = std::ranges::find(kNoLines, entity.type) == std::end(kNoLines);
    builder_.LeaveOut(entity.type, seen ? Effect::kLost : Effect::kNothingSeen,
                      entity.Place());
  }

  static std::string_view LayerOf(const DxfCommon& common, const BlockContext& in) {
    const bool floats = common.layer.empty() || common.layer == "0";
    return floats && !in.layer.empty() ? in.layer : common.layer;
  }

  /// A block inserted on a layer that is off shows its entities on other layers.
  bool IsShown(const DxfCommon& common, std::string_view layer, bool is_insert) {
    const DxfLayers::State state = layers_.StateOf(layer);
    std::string_view reason;
    if (state.off && !is_insert) reason = "on a layer that is off";
    if (state.frozen) reason = "on a frozen layer";
    if (common.invisible) reason = "invisible";
    if (common.paper_space) reason = "on a sheet";
    if (!reason.empty()) builder_.LeaveOut(reason, Effect::kNothingSeen);
    return reason.empty();
  }

  bool AddCurve(const DxfEntity& entity, const BlockContext& in) {
    DxfCurve result;
    if (!builder_.CountEntity(entity.Place()) || !DxfCurveOf(entity, builder_, result)) {
      return false;
    }
    const std::string_view layer = LayerOf(result.common, in);
    if (!IsShown(result.common, layer, false)) return true;
    if (layers_.IsDashed(result.common.line_type, layer))
      builder_.LeaveOut("dashes of a line type", Effect::kChanged, entity.Place());
    if (result.curve.pieces.empty()) {
      builder_.LeaveOut(result.wrong.empty()
                            ? std::string(entity.type)
                            : fmt::format("{} {}", entity.type, result.wrong),
                        Effect::kLost, entity.Place());
    }
    return Place(std::move(result.curve), false, result.common, entity, in);
  }

  bool AddHatch(const DxfEntity& entity, const BlockContext& in) {
    DxfHatch hatch;
    if (!ReadDxfHatch(entity, builder_, hatch)) return false;
    if (!IsShown(hatch.common, LayerOf(hatch.common, in), false)) return true;
    if (hatch.has_lines) {
      builder_.LeaveOut("pattern of a HATCH", Effect::kLost, entity.Place());
    }
    for (Curve& contour : hatch.contours) {
      if (!Place(std::move(contour), true, hatch.common, entity, in)) return false;
    }
    return true;
  }

  bool OpenFont() {
    auto opened = Typesetter::Open(*options_.text_font);
    if (!opened) {
      return builder_.Refuse(opened.error().code, "font of its texts",
                             opened.error().message, opened.error().value);
    }
    typesetter_ = std::move(*opened);
    return true;
  }

  bool AddText(const DxfEntity& entity, const BlockContext& in) {
    if (!typesetter_ && !OpenFont()) return false;
    DxfLettering text;
    if (!builder_.CountEntity(entity.Place()) ||
        !SetDxfText(entity, *typesetter_, builder_, text)) {
      return false;
    }
    if (!IsShown(text.common, LayerOf(text.common, in), false)) return true;
    if (!text.left_out.empty()) {
      builder_.LeaveOut(text.left_out, Effect::kLost, entity.Place());
    }
    for (Curve& curve : text.curves)
      if (!Place(std::move(curve), true, text.common, entity, in)) return false;
    return true;
  }

  /// Areas (hatches, letters) are cut as areas, all others as lines.
  bool Place(Curve curve, bool filled, const DxfCommon& common, const DxfEntity& entity,
             const BlockContext& in) {
    for (Piece& piece : curve.pieces) Transform(in.place.linear, in.place.offset, piece);
    curve.layer = builder_.NameIndex(LayerOf(common, in));
    curve.color = builder_.NameIndex(common.color);
    std::vector<Curve> seen;
    seen.push_back(std::move(curve));
    for (const auto& clip : in.clips) {
      std::vector<Curve> inside;
      bool is_cut = true;
      for (const Curve& part : seen)
        is_cut = is_cut && clip->Cut(part, filled, clip_work_, inside);
      if (is_cut) {
        seen = std::move(inside);
      } else {
        builder_.LeaveOut("XCLIP of a block, of this entity", Effect::kChanged,
                          entity.Place());
      }
    }
    for (Curve& part : seen)
      if (!builder_.Add(std::move(part), entity.Place())) return false;
    return true;
  }

  /// The clip of an inserted block at its place.
  void TakeClip(const DxfXclip& clip, const DxfInsert& insert, BlockContext& block) {
    std::string reason = clip.not_read;
    if (insert.columns > 1 || insert.rows > 1) reason = "of an array";
    if (reason.empty()) {
      if (auto area = clip.AreaOf(block.place, clip_work_)) {
        block.clips.push_back(std::make_shared<const ClipArea>(std::move(*area)));
      } else {
        reason = "not along z, or of too many edges";
      }
    }
    const auto leave_out = [&](std::string_view what) {
      builder_.LeaveOut(what, Effect::kChanged, clip.place);
    };
    if (!reason.empty()) return leave_out(fmt::format("XCLIP of a block, {}", reason));
    if (clip.has_planes) leave_out("plane of an XCLIP in front or behind");
    if (insert.has_attributes && options_.text_font) leave_out("XCLIP of an ATTRIB");
  }

  bool CheckInsert(const DxfEntity& entity, const DxfInsert& insert,
                   const std::string& name, const BlockContext& in) {
    const auto refuse = [&](ErrorCode code, std::string_view sentence) {
      return builder_.Refuse(code, entity.Place(), sentence, insert.block);
    };
    if (blocks_.Find(name) == nullptr) {
      return refuse(ErrorCode::kNotFound,
                    "the block that it inserts is not in the file; bind external "
                    "references before the export");
    }
    if (std::ranges::find(in.blocks, name) != in.blocks.end()) {
      return refuse(ErrorCode::kInvalidValue,
                    "the block contains itself; explode it in the drawing program");
    }
    if (in.blocks.size() >= static_cast<std::size_t>(options_.limits.max_nesting)) {
      return refuse(
          ErrorCode::kTooLarge,
          fmt::format(
              "blocks are nested more than {} deep; explode them in the drawing program",
              options_.limits.max_nesting));
    }
    return true;
  }

  bool UnfoldInsert(const DxfEntity& entity, const BlockContext& in) {
    DxfInsert insert;
    if (!ReadDxfInsert(entity, builder_, insert)) return false;
    const std::string_view layer = LayerOf(insert.common, in);
    if (!IsShown(insert.common, layer, true)) return true;
    const std::string name = io::LowerCase(insert.block);
    if (!CheckInsert(entity, insert, name, in)) return false;
    // Without height all of a flat block is there; without width or depth, nothing is.
    if (insert.scale.x() == 0 || insert.scale.y() == 0) {
      builder_.LeaveOut("INSERT with a scale of 0", Effect::kLost, entity.Place());
      return true;
    }
    const DxfBlock& block = *blocks_.Find(name);
    const DxfXclip* clip = xclips_.Find(insert.dictionary);
    BlockContext deeper{{}, in.blocks, layer, {}};
    deeper.blocks.push_back(name);
    // Files write 0 for "no array"; the entity limit bounds the loops.
    const double columns = std::max(1.0, insert.columns);
    const double rows = std::max(1.0, insert.rows);
    for (double row = 0; row < rows; ++row) {
      for (double column = 0; column < columns; ++column) {
        if (!builder_.CountEntity(entity.Place()) ||
            !builder_.CountUnfolded(block.text.text.size(), entity.Place())) {
          return false;
        }
        const Vec3 cell(column * insert.column_step, row * insert.row_step, 0);
        deeper.place = in.place.Then(DxfPlaceOf(insert, block.base, cell));
        deeper.clips = in.clips;
        if (clip != nullptr) TakeClip(*clip, insert, deeper);
        if (!Unfold(block.text, deeper)) return false;
      }
    }
    return true;
  }

  std::string_view text_;
  std::string decoded_;  ///< what text_ views when the file is not UTF-8
  ReadOptions options_;
  DrawingBuilder builder_;
  double unit_mm_ = 1;
  std::optional<Typesetter> typesetter_;  ///< when a text was met
  DxfLayers layers_;
  std::vector<DxfText> entities_;
  DxfBlocks blocks_;
  DxfXclips xclips_;
  ClipWork clip_work_;
};

}  // namespace

Result<Drawing> ReadDxf(std::string_view text, const ReadOptions& options,
                        std::string_view name) {
  RequireUsable(options);
  return DxfReader(text, options, name).Read();
}

}  // namespace intaglio::drawing
