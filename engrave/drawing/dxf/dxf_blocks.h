#pragma once

#include <string>
#include <unordered_map>

#include "engrave/drawing/dxf/dxf_groups.h"

namespace intaglio::drawing {

struct DxfBlock {
  DxfText text;  ///< its entities
  Vec3 base = Vec3::Zero();
};

/// The blocks of a file's section BLOCKS.
class DxfBlocks {
 public:
  /// False: the builder has the error.
  bool Read(const DxfText& section, DrawingBuilder& builder);

  /// By the name in small letters; null: there is none.
  const DxfBlock* Find(const std::string& name) const;

 private:
  std::unordered_map<std::string, DxfBlock> blocks_;
};

}  // namespace intaglio::drawing
