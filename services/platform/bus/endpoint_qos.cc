#include "services/platform/bus/endpoint_qos.h"

#include <dds/dds.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

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

/// The index of a name; nothing for a policy that is not announced.
template <typename Kind, typename Names>
std::optional<Kind> KindOf(const Names& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Kind>(found - names.begin());
}

template <typename T>
T NumberOf(const std::string& text, T otherwise) {
  T value = otherwise;
  (void)std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
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

QosPointer WriterQosOf(const std::map<std::string, std::string>& text) {
  constexpr char kKeepLast[] = "keep_last ";
  const auto entry = [&text](const char* policy) {
    const auto found = text.find(policy);
    return found == text.end() ? std::string() : found->second;
  };
  QosPointer qos(dds_create_qos());
  const auto reliability =
      KindOf<dds_reliability_kind_t>(kReliability, entry("reliability"));
  if (reliability) dds_qset_reliability(qos.get(), *reliability, DDS_MSECS(100));
  if (reliability == DDS_RELIABILITY_RELIABLE)
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  const std::string history = entry("history");
  const std::int32_t depth =
      history.starts_with(kKeepLast)
          ? std::max(1, NumberOf<std::int32_t>(history.substr(sizeof kKeepLast - 1), 1))
          : 1;
  if (const auto kind = KindOf<dds_durability_kind_t>(kDurability, entry("durability"))) {
    dds_qset_durability(qos.get(), *kind);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, depth, -1, -1, -1);
  }
  if (const auto deadline_ns = NumberOf<dds_duration_t>(entry("deadline_ns"), 0);
      deadline_ns > 0)
    dds_qset_deadline(qos.get(), deadline_ns);
  if (const auto kind = KindOf<dds_liveliness_kind_t>(kLiveliness, entry("liveliness"))) {
    dds_qset_liveliness(qos.get(), *kind,
                        NumberOf<dds_duration_t>(entry("lease_ns"), DDS_INFINITY));
  }
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

}  // namespace intaglio::bus::internal
