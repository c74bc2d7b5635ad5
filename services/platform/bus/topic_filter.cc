#include "services/platform/bus/topic_filter.h"

#include <fnmatch.h>

#include <algorithm>

#include "services/platform/bus/role_names.h"

namespace intaglio::bus {
namespace {

bool MatchesAny(const std::vector<std::string>& patterns, const std::string& name) {
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
  });
}

}  // namespace

bool NameFilter::Accepts(const std::string& name) const {
  return (only.empty() || MatchesAny(only, name)) && !MatchesAny(not_, name);
}

bool TopicFilter::Accepts(const std::string& topic_name, const std::string& partitions,
                          const std::string& type_name) const {
  if (!topic.Accepts(topic_name) || !type.Accepts(type_name)) return false;
  const bool of_no_machine = partitions.empty() || partitions == "*" ||
                             partitions.starts_with(kRolePartitionPrefix);
  if (of_no_machine) return true;
  for (std::size_t at = 0; at <= partitions.size();) {
    const auto end = std::min(partitions.find(',', at), partitions.size());
    if (partition.Accepts(partitions.substr(at, end - at))) return true;
    at = end + 1;
  }
  return false;
}

}  // namespace intaglio::bus
