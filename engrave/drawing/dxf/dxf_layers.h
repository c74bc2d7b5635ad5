#pragma once

#include <string>
#include <string_view>
#include <unordered_map>

#include "engrave/drawing/dxf/dxf_groups.h"

namespace intaglio::drawing {

/// Which layers of a drawing are switched off or frozen, from the records LAYER of the
/// section TABLES (DXF reference: a negative colour, 62; bit 1 of 70). Names are the same
/// in capitals and in small letters.
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

 private:
  std::unordered_map<std::string, State> hidden_;
};

}  // namespace intaglio::drawing
