#pragma once

// What a page shows to whoever makes a job: the glasses of the material base, and the
// machines of the shop and of the supplied profiles.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/console.pb.h"

namespace intaglio::console {

/// A machine of the shop, as its motion bridge reports it.
struct ShopMachine {
  std::string cell;
  std::filesystem::path profile;  ///< file on its computer; empty: it keeps none
};
/// Those that answer now. From any thread.
using ShopMachines = std::function<std::vector<ShopMachine>()>;

/// Reads the base and the profiles. A profile that cannot be read or is damaged is left
/// out. `materials`: material base, empty: the user's.
Result<JobChoices> ListJobChoices(const std::vector<ShopMachine>& shop,
                                  const std::string& materials);

}  // namespace intaglio::console
