#pragma once

// The QoS profiles by name: the one place where they are said.
//
// | profile | reliable | durability      | history     | lease                 | deadline
// |
// |---------|----------|-----------------|-------------|-----------------------|----------|
// | command | yes      | transient-local | keep last 1 | -                     | - | |
// state   | yes      | transient-local | keep last 1 | automatic, 2 s        | -        |
// | motion  | yes      | volatile        | keep all    | -                     | - | |
// event   | yes      | volatile        | keep all    | -                     | -        |
// | stream  | no       | volatile        | keep last 1 | -                     | 500 ms |
// | safety  | yes      | transient-local | keep last 1 | manual by topic 250 ms| 200 ms |
// | bulk    | yes      | volatile        | keep all    | -                     | - |
//
// The lease of state: a killed worker is noticed within 2 s; shorter ones flap when a
// build runs beside the services. Safety samples are written every 50 ms: five may be
// lost or late before the permission is gone. Keep-all readers have no resource limits,
// because a full one would stop its process; their producers stay within Credit.

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
