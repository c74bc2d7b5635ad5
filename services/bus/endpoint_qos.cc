#include "services/bus/endpoint_qos.h"

#include <dds/dds.h>
#include <fmt/format.h>

#include <array>

namespace intaglio::bus::internal {
namespace {

constexpr std::array kReliability = {"best_effort", "reliable"};
constexpr std::array kDurability = {"volatile", "transient_local", "transient",
                                    "persistent"};
constexpr std::array kLiveliness = {"automatic", "manual_by_participant",
                                    "manual_by_topic"};

template <typename Names, typename Kind>
std::string NameOf(const Names& names, Kind kind) {
  const auto at = static_cast<std::size_t>(kind);
  return at < names.size() ? names[at] : "unknown";
}

}  // namespace

std::string PartitionOf(const dds_qos* qos) {
  std::uint32_t count = 0;
  char** names = nullptr;
  if (!dds_qget_partition(qos, &count, &names)) return {};
  std::string text;
  for (std::uint32_t i = 0; i < count; ++i) {
    text += (text.empty() ? "" : ",") + std::string(names[i]);
    dds_free(names[i]);
  }
  dds_free(names);
  return text;
}

std::map<std::string, std::string> QosText(const dds_qos* qos) {
  std::map<std::string, std::string> text;
  dds_duration_t duration = 0;
  if (dds_reliability_kind_t kind; dds_qget_reliability(qos, &kind, &duration)) {
    text["reliability"] = NameOf(kReliability, kind);
  }
  if (dds_durability_kind_t kind; dds_qget_durability(qos, &kind)) {
    text["durability"] = NameOf(kDurability, kind);
  }
  std::int32_t depth = 0;
  if (dds_history_kind_t kind; dds_qget_history(qos, &kind, &depth)) {
    text["history"] = kind == DDS_HISTORY_KEEP_ALL ? std::string("keep_all")
                                                   : fmt::format("keep_last {}", depth);
  }
  if (dds_qget_deadline(qos, &duration) && duration != DDS_INFINITY) {
    text["deadline_ns"] = std::to_string(duration);
  }
  if (dds_liveliness_kind_t kind; dds_qget_liveliness(qos, &kind, &duration)) {
    text["liveliness"] = NameOf(kLiveliness, kind);
    if (duration != DDS_INFINITY) text["lease_ns"] = std::to_string(duration);
  }
  return text;
}

}  // namespace intaglio::bus::internal
