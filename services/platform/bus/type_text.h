#pragma once

// The IDL text of a type that was discovered, made from its XTypes type object. For
// services/platform/bus only.

#include <cstdint>
#include <optional>
#include <string>

struct ddsi_typeinfo;

namespace intaglio::bus::internal {

/// Time that a remote type is waited for: a round trip; a writer that has just come may
/// need longer and is asked again.
inline constexpr std::int64_t kTypeTimeoutNs = 500'000'000;

struct TypeText {
  std::string idl;      ///< the type and all that it is made of
  std::string key_idl;  ///< a struct <name>_key of the key members alone; empty: no key
};

/// Nothing when the writer announced only the minimal type (which has no names), when a
/// part of it is not to be had, or when it has maps, wide characters or bit sets. A bit
/// mask becomes the unsigned number that it is on the wire.
std::optional<TypeText> TextOf(std::int32_t participant, const ddsi_typeinfo* type);

}  // namespace intaglio::bus::internal
