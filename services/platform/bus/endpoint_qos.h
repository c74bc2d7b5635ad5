#pragma once

// The QoS and partitions that a writer announces when it is discovered, as text, and a
// writer made from that text. For services/platform/bus only.

#include <map>
#include <string>

#include "services/platform/bus/qos.h"

struct dds_qos;

namespace intaglio::bus::internal {

/// Its partitions, separated by commas; empty: none.
std::string PartitionOf(const dds_qos* qos);
/// reliability, durability, history, deadline_ns, liveliness and lease_ns, as far as
/// announced.
std::map<std::string, std::string> QosText(const dds_qos* qos);
/// The same the other way; what is not announced has the library's default. A reliable
/// writer keeps all until it is acknowledged, which no reader sees: a sample that another
/// one has overtaken was sent all the same. Late readers of a retained topic get as many
/// samples as the first writer kept.
QosPointer WriterQosOf(const std::map<std::string, std::string>& text);

}  // namespace intaglio::bus::internal
