#pragma once

// The lines of a DXF file: pairs of a code and a value, and the entities made of them.
// All are views of the file's text: nothing is stored.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engrave/core/geometry.h"
#include "engrave/drawing/drawing_builder.h"

namespace intaglio::drawing {

struct DxfGroup {
  int code = 0;
  std::string_view value;  ///< without blanks around it
  std::string_view raw;    ///< with them
  std::uint64_t line = 0;  ///< of the code, from 1
};

/// A piece of the file with the number of its first line.
struct DxfText {
  std::string_view text;
  std::uint64_t line = 1;
};

class DxfGroups {
 public:
  DxfGroups(const DxfText& text, DrawingBuilder& builder)
      : text_(text.text), line_(text.line), builder_(builder) {}

  /// False at the end, and when a line is broken: then the builder has the error.
  bool Next(DxfGroup& group);
  /// False after a broken line.
  bool good() const { return good_; }
  std::uint64_t line() const { return line_; }
  std::size_t position() const { return position_; }
  std::string_view From(std::size_t begin, std::size_t end) const {
    return text_.substr(begin, end - begin);
  }

 private:
  std::string_view NextLine();

  std::string_view text_;
  std::size_t position_ = 0;
  std::uint64_t line_ = 1;
  DrawingBuilder& builder_;
  bool good_ = true;
};

/// One entity with the groups behind its type; a POLYLINE with its vertices.
struct DxfEntity {
  std::string_view type;
  DxfText groups;
  std::string Place() const;  ///< "line 12, ARC"
};

/// The entities of a section or block, one after another.
class DxfEntities {
 public:
  DxfEntities(const DxfText& text, DrawingBuilder& builder);
  /// False at the end or after an error.
  bool Next(DxfEntity& entity);
  bool good() const { return groups_.good(); }

 private:
  bool ReadOn();

  DxfGroups groups_;
  DxfGroup group_;
  bool has_group_ = false;
};

/// The groups that every entity may have.
struct DxfCommon {
  std::string_view layer;
  std::string_view line_type;  ///< empty: that of the layer
  std::string color;           ///< number of the palette, or "#rrggbb"
  bool paper_space = false;    ///< on a sheet, not in the model
  bool invisible = false;
  Vec3 extrusion = Vec3::UnitZ();
};

/// The error of an entity with such a value; false.
bool Refuse(const DxfEntity& entity, DrawingBuilder& builder, std::string_view sentence,
            double value);

/// The value of a group as a number; the error names the line. `number` finite.
bool DxfNumber(const DxfGroup& group, const DxfEntity& entity, DrawingBuilder& builder,
               double& number);

/// Takes the group into `common` when it is one of those that every entity may have.
/// False: an error.
bool TakeCommon(const DxfGroup& group, const DxfEntity& entity, DrawingBuilder& builder,
                DxfCommon& common);

/// The axes of an entity's own coordinate system from its extrusion (arbitrary axis
/// algorithm, DXF reference); one without length counts as z.
Mat3 WorldFromEntity(const Vec3& extrusion);

}  // namespace intaglio::drawing
