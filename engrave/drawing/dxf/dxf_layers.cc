#include "engrave/drawing/dxf/dxf_layers.h"

#include <fmt/format.h>

#include "engrave/io/lower_case.h"

namespace intaglio::drawing {
namespace {

constexpr int kFrozen = 1;  // of group 70

}  // namespace

bool DxfLayers::Read(const DxfText& tables, DrawingBuilder& builder) {
  DxfEntities records(tables, builder);
  DxfEntity record;
  while (records.Next(record)) {
    if (record.type != "LAYER") continue;
    std::string_view name;
    double color = 7, flags = 0;
    DxfGroups groups(record.groups, builder);
    DxfGroup group;
    while (groups.Next(group)) {
      if (group.code == 2) name = group.value;
      if (group.code != 62 && group.code != 70) continue;
      if (!DxfNumber(group, record, builder, group.code == 62 ? color : flags)) {
        return false;
      }
    }
    if (!groups.good()) return false;
    const bool frozen =
        flags > 0 && flags < 65536 && (static_cast<int>(flags) & kFrozen) != 0;
    const State state{color < 0, frozen};
    if (!state.off && !state.frozen) continue;
    if (hidden_.size() >= builder.limits().max_entities) {
      return builder.Refuse(ErrorCode::kTooLarge, record.Place(),
                            fmt::format("more than {} layers; purge the drawing",
                                        builder.limits().max_entities));
    }
    hidden_.insert_or_assign(io::LowerCase(name), state);
  }
  return records.good();
}

DxfLayers::State DxfLayers::StateOf(std::string_view name) const {
  if (hidden_.empty()) return {};
  const auto found = hidden_.find(io::LowerCase(name));
  return found == hidden_.end() ? State() : found->second;
}

}  // namespace intaglio::drawing
