#include "engrave/drawing/dxf/dxf_blocks.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/io/lower_case.h"

namespace intaglio::drawing {

bool DxfBlocks::Read(const DxfText& section, DrawingBuilder& builder) {
  DxfGroups groups(section, builder);
  DxfGroup group;
  bool inside = false, in_head = false;
  DxfBlock block;
  std::string_view name;
  std::size_t begin = 0, end = 0;
  while (groups.Next(group)) {
    if (group.code == 0) {
      in_head = false;
      if (inside && group.value == "ENDBLK") {
        block.text.text = groups.From(begin, std::max(begin, end));
        blocks_.insert_or_assign(io::LowerCase(name), block);
        inside = false;
      } else if (!inside && group.value == "BLOCK") {
        if (blocks_.size() >= builder.limits().max_entities) {
          return builder.Refuse(ErrorCode::kTooLarge, fmt::format("line {}", group.line),
                                fmt::format("more than {} blocks; purge the drawing",
                                            builder.limits().max_entities));
        }
        inside = in_head = true;
        block = DxfBlock{{{}, groups.line()}, Vec3::Zero()};
        begin = groups.position();
        name = {};
      }
    } else if (in_head) {
      if (group.code == 2) name = group.value;
      if (group.code == 10 || group.code == 20 || group.code == 30) {
        const DxfEntity head{"BLOCK", {}};
        if (!DxfNumber(group, head, builder, block.base[group.code / 10 - 1])) {
          return false;
        }
      }
      begin = groups.position();
      block.text.line = groups.line();
    }
    end = groups.position();
  }
  return groups.good();
}

const DxfBlock* DxfBlocks::Find(const std::string& name) const {
  const auto found = blocks_.find(name);
  return found == blocks_.end() ? nullptr : &found->second;
}

}  // namespace intaglio::drawing
