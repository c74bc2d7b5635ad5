#include "engrave/drawing/dxf/dxf_groups.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>

#include "engrave/io/trimmed_line.h"

namespace intaglio::drawing {
namespace {

std::string LinePlace(std::uint64_t line) { return fmt::format("line {}", line); }

}  // namespace

std::string_view DxfGroups::NextLine() {
  const auto end = text_.find('\n', position_);
  const auto stop = end == text_.npos ? text_.size() : end;
  const std::string_view line = text_.substr(position_, stop - position_);
  position_ = end == text_.npos ? text_.size() : end + 1;
  ++line_;
  return line.ends_with('\r') ? line.substr(0, line.size() - 1) : line;
}

bool DxfGroups::Next(DxfGroup& group) {
  if (!good_ || position_ == text_.size()) return false;
  group.line = line_;
  const std::string_view code = io::TrimmedLine(NextLine());
  if (position_ == text_.size()) {
    if (code.empty()) return false;
    good_ = builder_.Refuse(
        ErrorCode::kUnreadable, LinePlace(group.line),
        "the file ends within a group; it is truncated, copy it again", code);
    return false;
  }
  const auto [end, failure] =
      std::from_chars(code.data(), code.data() + code.size(), group.code);
  if (failure != std::errc() || end != code.data() + code.size()) {
    good_ = builder_.Refuse(ErrorCode::kUnreadable, LinePlace(group.line),
                            "expected a group code, a whole number; the file is damaged "
                            "or not DXF in text form, export it again",
                            code);
    return false;
  }
  group.raw = NextLine();
  group.value = io::TrimmedLine(group.raw);
  return true;
}

std::string DxfEntity::Place() const {
  return fmt::format("line {}, {}", groups.line > 2 ? groups.line - 2 : 1, Shown(type));
}

DxfEntities::DxfEntities(const DxfText& text, DrawingBuilder& builder)
    : groups_(text, builder) {
  while (ReadOn() && group_.code != 0) {
  }
}

bool DxfEntities::ReadOn() {
  has_group_ = groups_.Next(group_);
  return has_group_;
}

bool DxfEntities::Next(DxfEntity& entity) {
  if (!has_group_) return false;
  entity.type = group_.value;
  entity.groups.line = groups_.line();
  const std::size_t begin = groups_.position();
  const bool with_vertices = entity.type == "POLYLINE";
  std::size_t end = begin;
  bool in_vertices = with_vertices;
  while (true) {
    end = groups_.position();
    if (!ReadOn()) break;
    if (group_.code != 0) continue;
    if (in_vertices && group_.value == "VERTEX") continue;
    if (in_vertices && group_.value == "SEQEND") {
      in_vertices = false;
      continue;
    }
    break;
  }
  entity.groups.text = groups_.From(begin, has_group_ ? end : groups_.position());
  return groups_.good();
}

bool Refuse(const DxfEntity& entity, DrawingBuilder& builder, std::string_view sentence,
            double value) {
  return builder.Refuse(ErrorCode::kInvalidValue, entity.Place(), sentence,
                        fmt::format("{}", value));
}

bool DxfNumber(const DxfGroup& group, const DxfEntity& entity, DrawingBuilder& builder,
               double& number) {
  const std::optional<double> value = NumberOf(group.value);
  if (value) {
    number = *value;
    return true;
  }
  return builder.Refuse(
      ErrorCode::kInvalidValue,
      fmt::format("line {}, {}", group.line + 1, Shown(entity.type)),
      fmt::format("the value of group {} is not a finite number; correct the entity or "
                  "export the drawing again",
                  group.code),
      group.value);
}

bool TakeCommon(const DxfGroup& group, const DxfEntity& entity, DrawingBuilder& builder,
                DxfCommon& common) {
  double number = 0;
  switch (group.code) {
    case 6:
      common.line_type = group.value;
      return true;
    case 8:
      common.layer = group.value;
      return true;
    case 62:
      common.color = Shown(group.value);
      return true;
    case 60:
    case 67:
      if (!DxfNumber(group, entity, builder, number)) return false;
      (group.code == 67 ? common.paper_space : common.invisible) = number != 0;
      return true;
    case 210:
    case 220:
    case 230:
      return DxfNumber(group, entity, builder, common.extrusion[(group.code - 210) / 10]);
    case 420:
      if (!DxfNumber(group, entity, builder, number)) return false;
      if (number >= 0 && number <= 0xFFFFFF) {
        common.color = fmt::format("#{:06x}", static_cast<std::uint32_t>(number));
      }
      return true;
    default:
      return true;
  }
}

Mat3 WorldFromEntity(const Vec3& extrusion) {
  const Vec3 z = extrusion.isZero(0) ? Vec3(Vec3::UnitZ()) : extrusion.stableNormalized();
  const bool near_world_z = std::abs(z.x()) < 1.0 / 64 && std::abs(z.y()) < 1.0 / 64;
  const Vec3 x = (near_world_z ? Vec3::UnitY() : Vec3::UnitZ()).cross(z).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return axes;
}

}  // namespace intaglio::drawing
