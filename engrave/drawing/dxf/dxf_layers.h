#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "engrave/drawing/dxf/dxf_groups.h"

namespace intaglio::drawing {

/// Which layers of a drawing are switched off or frozen, from the records LAYER of the
/// section TABLES (DXF reference: a negative colour, 62; bit 1 of 70), and which line
/// types have dashes, from its records LTYPE (73, their number). Names are the same in
/// capitals and in small letters.
class DxfLayers {
 public:
  struct State {
    bool off = false;     ///< entities on this layer are not drawn
    bool frozen = false;  ///< nor are entities on other layers in blocks inserted on it
  };

  /// False: the builder has the error.
  bool Read(const DxfText& tables, DrawingBuilder& builder);

  /// A layer without a record is on.
  State StateOf(std::string_view name) const;
  /// Whether the lines of an entity with this line type, on this layer, have dashes.
  bool IsDashed(std::string_view line_type, std::string_view layer) const;

 private:
  bool ReadLayer(const DxfEntity& record, DrawingBuilder& builder);
  bool ReadLineType(const DxfEntity& record, DrawingBuilder& builder);
  bool CheckCount(std::size_t count, const DxfEntity& record, DrawingBuilder& builder);

  std::unordered_map<std::string, State> hidden_;
  std::unordered_map<std::string, std::string> line_types_;  ///< of layers
  std::unordered_set<std::string> dashed_;                   ///< line types
};

}  // namespace intaglio::drawing
