#pragma once

// Key, door and stop button of many machines are one chain with one input: grbl, isel,
// the boards of scan heads. When it opens, all three are reported open, and which of them
// a person has to close is not known. A message names all three then.

#include <string_view>

namespace intaglio::bus {

inline constexpr std::string_view kChainIsOpen = "key, door or stop button is open";

/// All three are reported open, as by a machine whose chain they are.
constexpr bool IsChainOpen(bool key_on, bool door_closed, bool stop_released) {
  return !key_on && !door_closed && !stop_released;
}

}  // namespace intaglio::bus
