#pragma once

#include <chrono>
#include <memory>

#include "services/client/shop/shop_snapshot.h"

namespace intaglio::cli {

inline constexpr std::chrono::milliseconds kShopPollPeriod{50};

/// A shop that is watched.
struct WatchedShop {
  explicit WatchedShop(const bus::BusOptions& options) : bus(options), shop(bus) {}

  bus::Bus bus;
  client::ShopWatcher shop;
};

/// Joins a shop and waits until all that a working shop has is here, or for as long as
/// that takes (patience.h), or until Ctrl-C: what is not here then is missing.
std::unique_ptr<WatchedShop> WatchShop(const bus::BusOptions& options);

}  // namespace intaglio::cli
