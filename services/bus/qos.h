#pragma once

// The QoS profiles by name: the one place where they are said.
//
// - command: reliable, transient-local, keep last 1;
// - state: the same, with an automatic lease of 1.5 s;
// - motion, event, bulk: reliable, volatile, keep all;
// - stream: best effort, volatile, keep last 1, deadline 500 ms;
// - safety: reliable, transient-local, keep last 1, lease by topic 250 ms, deadline 200
// ms.
//
// The lease of state: a killed worker is noticed within 1.5 s; the library renews it
// every 1.2 s and health is written every 200 ms, so that it holds while a build runs
// beside the services. Safety samples are written every 50 ms: five may be lost or late
// before the permission is gone. Keep-all readers have no resource limits, because a full
// one would stop its process; their producers stay within Credit.

#include <memory>

#include "services/bus/topics.h"

struct dds_qos;

namespace intaglio::bus::internal {

struct QosDeleter {
  void operator()(dds_qos* qos) const noexcept;
};
using QosPointer = std::unique_ptr<dds_qos, QosDeleter>;

QosPointer QosOf(Profile profile);

}  // namespace intaglio::bus::internal
