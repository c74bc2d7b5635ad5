#pragma once

// What a writer tells of itself when it is discovered, as text. For services/bus only.

#include <map>
#include <string>

struct dds_qos;

namespace intaglio::bus::internal {

/// Its partitions, separated by commas; empty: none.
std::string PartitionOf(const dds_qos* qos);
/// reliability, durability, history, deadline_ns, liveliness and lease_ns, as far as
/// told.
std::map<std::string, std::string> QosText(const dds_qos* qos);

}  // namespace intaglio::bus::internal
