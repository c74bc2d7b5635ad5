#pragma once

#include <ctime>
#include <string>

#include "proto/shop.pb.h"

namespace intaglio::cli {

/// One screen for people. `now`: when the jobs' ends are reckoned from.
std::string TextOf(const ShopStatus& status, std::time_t now = std::time(nullptr));

}  // namespace intaglio::cli
