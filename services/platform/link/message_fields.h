#pragma once

// The fields of a message, written down once for both directions: a protocol specializes
// Layout for each of its messages, and the same function writes the fields to bytes and
// reads and checks them. Included by the protocols' sources alone.
//
//   template <>
//   struct Layout<BeginRun> {
//     static constexpr const char* kName = "BeginRun";
//     static void Fields(auto& io, auto& m) {
//       io.Number(m.run);
//       io.Require(m.run > 0);
//     }
//   };
//   template Bytes Encode(const BeginRun&);
//   template Result<BeginRun> Decode(std::span<const std::byte>);

#include <cstdint>
#include <string>
#include <type_traits>

#include "services/platform/link/byte_codec.h"
#include "services/platform/link/message.h"

namespace intaglio::link {

template <typename Message>
struct Layout;

class FieldWriter {
 public:
  static constexpr bool kReads = false;

  template <typename T>
  void Number(const T& value) {
    out_.Put(value);
  }
  /// One byte, 0 or 1.
  void Flag(bool value) { out_.Put(static_cast<std::uint8_t>(value)); }
  /// One byte, the first of `flags` in its lowest bit.
  template <typename... Flags>
  void Bits(const Flags&... flags) {
    unsigned byte = 0, bit = 0;
    ((byte |= (flags ? 1u : 0u) << bit++), ...);
    out_.Put(static_cast<std::uint8_t>(byte));
  }
  /// One byte, at most `last`.
  template <typename E>
  void Enumerator(const E& value, E last) {
    (void)last;
    out_.Put(static_cast<std::uint8_t>(value));
  }
  void Text(const std::string& text, std::size_t max_size) {
    out_.PutText(text, max_size);
  }
  void PrintableText(const std::string& text, std::size_t max_size) {
    out_.PutText(text, max_size);
  }
  /// How many elements the list has, `min` to `max`, as a number of this type; each
  /// element follows by itself.
  template <typename Count, typename List>
  void Size(const List& list, std::size_t min, std::size_t max) {
    (void)min, (void)max;
    out_.Put(static_cast<Count>(list.size()));
  }
  /// `count` bits, eight in a byte, the first in its lowest bit; `at` gives a reference
  /// to each.
  template <typename At>
  void BitRow(std::size_t count, At at) {
    for (std::size_t i = 0; i < count; i += 8) {
      unsigned bits = 0;
      for (std::size_t j = 0; j < 8 && i + j < count; ++j)
        bits |= (at(i + j) ? 1u : 0u) << j;
      out_.Put(static_cast<std::uint8_t>(bits));
    }
  }
  void Require(bool) {}
  Bytes TakeBytes() { return out_.Take(); }

 private:
  ByteWriter out_;
};

class FieldReader {
 public:
  static constexpr bool kReads = true;

  explicit FieldReader(std::span<const std::byte> payload) : in_(payload) {}

  template <typename T>
  void Number(T& value) {
    value = in_.Get<T>();
  }
  void Flag(bool& value) { value = in_.GetFlag(); }
  template <typename... Flags>
  void Bits(Flags&... flags) {
    unsigned byte = in_.Get<std::uint8_t>();
    ((flags = (byte & 1) != 0, byte >>= 1), ...);
    Require(byte == 0);
  }
  template <typename E>
  void Enumerator(E& value, E last) {
    value = static_cast<E>(in_.Get<std::uint8_t>());
    Require(value <= last);
  }
  void Text(std::string& text, std::size_t max_size) { text = in_.GetText(max_size); }
  void PrintableText(std::string& text, std::size_t max_size) {
    text = in_.GetPrintableText(max_size);
  }
  template <typename Count, typename List>
  void Size(List& list, std::size_t min, std::size_t max) {
    const std::size_t size = in_.Get<Count>();
    Require(in_.good() && size >= min && size <= max);
    list.resize(good_ ? size : 0);
  }
  template <typename At>
  void BitRow(std::size_t count, At at) {
    for (std::size_t i = 0; i < count; i += 8) {
      unsigned bits = in_.Get<std::uint8_t>();
      for (std::size_t j = 0; j < 8 && i + j < count; ++j, bits >>= 1)
        at(i + j) = (bits & 1) != 0;
      if (count - i < 8) Require(bits == 0);
    }
  }
  /// The message is refused unless it holds.
  void Require(bool condition) { good_ = good_ && condition; }
  bool finished() const { return good_ && in_.finished(); }

 private:
  ByteReader in_;
  bool good_ = true;
};

template <typename Message>
Bytes Encode(const Message& message) {
  FieldWriter io;
  Layout<Message>::Fields(io, message);
  return io.TakeBytes();
}

template <typename Message>
Result<Message> Decode(std::span<const std::byte> payload) {
  FieldReader io(payload);
  Message message;
  Layout<Message>::Fields(io, message);
  if (io.finished()) return message;
  using L = Layout<Message>;
  return Fail(ErrorCode::kUnreadable,
              std::string(L::kLine) + ": a frame " + L::kName + " is malformed",
              L::kName);
}

}  // namespace intaglio::link
