#pragma once

// The QoS profiles by name: the one place where they are defined.
//
// - command: reliable, transient-local, keep last 1;
// - state: the same, with an automatic lease of 1.5 s;
// - motion, event, bulk: reliable, volatile, keep all; writers of motion and event keep
//   the newest 64 and 512 samples that are not acknowledged;
// - stream: best effort, volatile, keep last 1, deadline 500 ms;
// - safety: reliable, transient-local, keep last 1, lease by topic 250 ms, deadline 200
// ms.
//
// The lease of state: a killed worker is noticed within 1.5 s; the library renews it
// every 1.2 s and health is written every 600 ms, so that it holds while a build runs
// beside the services. Safety samples are written every 50 ms: five may be lost or late
// before the permission is gone. Keep-all readers have no resource limits, because a full
// one would stop its process; their producers stay within Credit.
//
// A writer that keeps all waits, and its memory grows, when a reader acknowledges
// nothing. Any observer may be such a reader of pulses and positions, so their writers go
// on without that reader after several seconds' worth of samples. The window of a motion
// stream is 16 batches, so a reader that follows it misses none of 64. Together with the
// control domain's high watermark (bus.cc) no write of control topics ever waits.

#include <memory>

#include "services/platform/bus/topics.h"

struct dds_qos;

namespace intaglio::bus::internal {

struct QosDeleter {
  void operator()(dds_qos* qos) const noexcept;
};
using QosPointer = std::unique_ptr<dds_qos, QosDeleter>;

enum class Side { kReader, kWriter };

/// Topics are made with that of readers.
QosPointer QosOf(Profile profile, Side side = Side::kReader);

}  // namespace intaglio::bus::internal
