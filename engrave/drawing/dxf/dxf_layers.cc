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
    if (record.type == "LAYER" && !ReadLayer(record, builder)) return false;
    if (record.type == "LTYPE" && !ReadLineType(record, builder)) return false;
  }
  return records.good();
}

bool DxfLayers::CheckCount(std::size_t count, const DxfEntity& record,
                           DrawingBuilder& builder) {
  const std::uint64_t largest = builder.limits().max_entities;
  if (count < largest) return true;
  return builder.Refuse(
      ErrorCode::kTooLarge, record.Place(),
      fmt::format("more than {} layers or line types; purge the drawing", largest));
}

bool DxfLayers::ReadLayer(const DxfEntity& record, DrawingBuilder& builder) {
  std::string_view name, line_type;
  double color = 7, flags = 0;
  DxfGroups groups(record.groups, builder);
  DxfGroup group;
  while (groups.Next(group)) {
    if (group.code == 2) name = group.value;
    if (group.code == 6) line_type = group.value;
    if (group.code != 62 && group.code != 70) continue;
    if (!DxfNumber(group, record, builder, group.code == 62 ? color : flags)) {
      return false;
    }
  }
  if (!groups.good() || !CheckCount(line_types_.size(), record, builder)) return false;
  line_types_.insert_or_assign(io::LowerCase(name), io::LowerCase(line_type));
  const bool frozen =
      flags > 0 && flags < 65536 && (static_cast<int>(flags) & kFrozen) != 0;
  const State state{color < 0, frozen};
  if (state.off || state.frozen) hidden_.insert_or_assign(io::LowerCase(name), state);
  return true;
}

bool DxfLayers::ReadLineType(const DxfEntity& record, DrawingBuilder& builder) {
  std::string_view name;
  double dash_count = 0;
  DxfGroups groups(record.groups, builder);
  DxfGroup group;
  while (groups.Next(group)) {
    if (group.code == 2) name = group.value;
    if (group.code == 73 && !DxfNumber(group, record, builder, dash_count)) return false;
  }
  if (!groups.good() || !CheckCount(dashed_.size(), record, builder)) return false;
  if (dash_count > 0) dashed_.insert(io::LowerCase(name));
  return true;
}

DxfLayers::State DxfLayers::StateOf(std::string_view name) const {
  if (hidden_.empty()) return {};
  const auto found = hidden_.find(io::LowerCase(name));
  return found == hidden_.end() ? State() : found->second;
}

bool DxfLayers::IsDashed(std::string_view line_type, std::string_view layer) const {
  if (dashed_.empty()) return false;
  const std::string own = io::LowerCase(line_type);
  if (!own.empty() && own != "bylayer") return dashed_.contains(own);
  const auto of_layer = line_types_.find(io::LowerCase(layer));
  return of_layer != line_types_.end() && dashed_.contains(of_layer->second);
}

}  // namespace intaglio::drawing
