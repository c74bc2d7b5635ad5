#include "engrave/drawing/dxf/dxf_insert.h"

#include <cmath>
#include <numbers>

namespace intaglio::drawing {

bool ReadDxfInsert(const DxfEntity& entity, DrawingBuilder& builder, DxfInsert& insert) {
  DxfGroups groups(entity.groups, builder);
  DxfGroup group;
  bool in_dictionary = false;
  while (groups.Next(group)) {
    if (!TakeCommon(group, entity, builder, insert.common)) return false;
    double* number = nullptr;
    switch (group.code) {
      case 2:
        insert.block = group.value;
        break;
      case 66:
        insert.has_attributes = group.value != "0";
        break;
      case 102:
        in_dictionary = group.value == "{ACAD_XDICTIONARY";
        break;
      case 360:
        if (in_dictionary) insert.dictionary = group.value;
        break;
      case 10:
      case 20:
      case 30:
        number = &insert.at[group.code / 10 - 1];
        break;
      case 41:
      case 42:
      case 43:
        number = &insert.scale[group.code - 41];
        break;
      case 44:
        number = &insert.column_step;
        break;
      case 45:
        number = &insert.row_step;
        break;
      case 50:
        number = &insert.rotation_deg;
        break;
      case 70:
        number = &insert.columns;
        break;
      case 71:
        number = &insert.rows;
        break;
      default:
        break;
    }
    if (number != nullptr && !DxfNumber(group, entity, builder, *number)) return false;
  }
  return groups.good();
}

DxfAffine DxfPlaceOf(const DxfInsert& insert, const Vec3& base, const Vec3& cell) {
  const double turn = insert.rotation_deg * std::numbers::pi / 180;
  Mat3 turned = Mat3::Identity();
  turned.topLeftCorner<2, 2>() << std::cos(turn), -std::sin(turn), std::sin(turn),
      std::cos(turn);
  const Mat3 world = WorldFromEntity(insert.common.extrusion);
  const Mat3 linear = world * turned * insert.scale.asDiagonal();
  return {linear, world * (insert.at + turned * cell) - linear * base};
}

}  // namespace intaglio::drawing
