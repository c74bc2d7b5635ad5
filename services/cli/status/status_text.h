#pragma once

#include <string>

#include "proto/shop.pb.h"

namespace intaglio::cli {

/// One screen for people.
std::string TextOf(const ShopStatus& status);

}  // namespace intaglio::cli
