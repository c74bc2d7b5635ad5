#pragma once

// What a snapshot of a shop says: pure, from the samples to the message.

#include <chrono>

#include "proto/shop.pb.h"
#include "services/client/shop/shop_snapshot.h"

namespace intaglio::client {

/// A job needs some MB for its plan, journal and report; below this a person makes room.
inline constexpr double kLowDiskBytes = 100e6;

/// A living service reports every 600 ms. Of one that is silent so long, what is shown
/// may not be true any more.
inline constexpr double kStaleAge_s = 5;

/// A person is needed when a service is missing or is silent for kStaleAge_s, reports a
/// fault or has another version, a line is down, a stop is pressed, an interlock is open
/// at a machine that has a job, a job is paused or waits for its arm, an alarm is raised,
/// or a disk is nearly full.
ShopStatus StatusOf(const ShopSnapshot& shop, std::chrono::system_clock::time_point now);

}  // namespace intaglio::client
