#pragma once

#include "engrave/drawing/dxf/dxf_groups.h"

namespace intaglio::drawing {

struct DxfAffine {
  Mat3 linear = Mat3::Identity();
  Vec3 offset = Vec3::Zero();

  DxfAffine Then(const DxfAffine& inner) const {
    return {linear * inner.linear, linear * inner.offset + offset};
  }
};

/// The numbers of an INSERT that matter.
struct DxfInsert {
  std::string_view block;
  std::string_view dictionary;  ///< handle of the extension dictionary
  bool has_attributes = false;
  DxfCommon common;
  Vec3 at = Vec3::Zero();
  Vec3 scale = Vec3::Ones();
  double rotation_deg = 0;
  double columns = 1;
  double rows = 1;
  double column_step = 0;
  double row_step = 0;
};

/// False: the builder has the error.
bool ReadDxfInsert(const DxfEntity& entity, DrawingBuilder& builder, DxfInsert& insert);

/// The block's frame in that of the drawing: base to origin, scale, cell of the array,
/// turn, insertion point, extrusion.
DxfAffine DxfPlaceOf(const DxfInsert& insert, const Vec3& base, const Vec3& cell);

}  // namespace intaglio::drawing
