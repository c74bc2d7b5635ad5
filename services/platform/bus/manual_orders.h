#pragma once

// Numbers of orders by hand (ManualCommand.number). An order has that of the machine's
// state at which it began, and each machine's service counts its states from a random
// number: so a service that was started again tells an order that somebody holds since
// before from one that begins.

#include <cstdint>

namespace intaglio::bus {

/// So many orders may begin at one state, each with a number of its own.
inline constexpr std::uint64_t kMaxOrdersOfAState = 64;

/// The number of an order that begins at the state `seen`, behind the sender's `last`.
inline std::uint64_t NumberOfOrder(std::uint64_t last, std::uint64_t seen) {
  const bool of_one_service = last >= seen && last - seen < kMaxOrdersOfAState;
  return of_one_service ? last + 1 : seen;
}

/// It began at one of the states from `first` to `newest`.
inline bool BeganAmong(std::uint64_t number, std::uint64_t first, std::uint64_t newest) {
  return number >= first && number - first <= newest - first + kMaxOrdersOfAState;
}

}  // namespace intaglio::bus
