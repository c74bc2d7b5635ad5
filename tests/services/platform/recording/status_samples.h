#pragma once

// Samples of a keyed type, made by hand: { uint32 id (key); uint32 value; octets }.

#include <cstdint>
#include <cstring>
#include <string>

#include "services/platform/recording/conventions.h"

namespace intaglio::recording {

inline constexpr char kStatusIdl[] =
    "module m { @final struct Status { @key uint32 id; uint32 value; "
    "sequence<octet> filling; }; };";
inline constexpr char kStatusKeyIdl[] =
    "module m { @final struct Status_key { @key uint32 id; }; };";
inline constexpr char kStatusKeys[] = "id 0 0;";

/// Little-endian plain CDR.
inline Bytes TextAsCdr(std::initializer_list<std::uint32_t> words,
                       std::size_t filling = 0) {
  Bytes bytes(4 + 4 * words.size() + filling);
  bytes[1] = std::byte{1};
  std::size_t at = 4;
  for (const std::uint32_t word : words) {
    std::memcpy(bytes.data() + at, &word, sizeof word);
    at += sizeof word;
  }
  return bytes;
}

inline Bytes StatusOf(std::uint32_t id, std::uint32_t value, std::uint32_t filling = 0) {
  return TextAsCdr({id, value, filling}, filling);
}
inline Bytes StatusKeyOf(std::uint32_t id) { return TextAsCdr({id}); }

/// Its stream: retained, keep last `depth`.
inline Stream StatusStream(SampleKind kind = SampleKind::kValue, int depth = 1) {
  return {"Status",
          "m::Status",
          false,
          "cell",
          kind,
          true,
          {{"durability", "transient_local"},
           {"history", "keep_last " + std::to_string(depth)}}};
}

}  // namespace intaglio::recording
