#pragma once

// A message's value, decoded by its schema: plain CDR (XCDR1) and XCDR2, of both byte
// orders. Every length is checked against the bytes that are there.

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "engrave/core/result.h"
#include "services/platform/recording/idl_types.h"
#include "services/platform/recording/mcap_fields.h"

namespace intaglio::recording {

struct Value;
struct ValueMember;
using ValueList = std::vector<Value>;
/// Members in the order of the type.
using ValueObject = std::vector<ValueMember>;

/// A number, text, list or object; enums are the names of their values. Lists of numbers
/// are kept as such: a batch has hundreds of thousands.
struct Value {
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string,
               std::vector<double>, std::vector<std::int64_t>, std::vector<std::uint64_t>,
               ValueList, ValueObject>
      held;

  /// The member of that name, or null.
  const Value* Find(const std::string& name) const;
  /// Null when it is of another kind.
  template <typename T>
  const T* As() const {
    return std::get_if<T>(&held);
  }
};

struct ValueMember {
  std::string name;
  Value value;
};

/// What the member of that name holds; empty or 0 when it is not there, or of another
/// kind.
template <typename T>
const T& MemberOf(const Value& value, const std::string& name) {
  static const T none{};
  const Value* const member = value.Find(name);
  const T* const held = member == nullptr ? nullptr : member->As<T>();
  return held == nullptr ? none : *held;
}

/// kUnreadable when the bytes are not such a message, kUnsupported for an encoding or
/// type that is not handled.
Result<Value> DecodeCdr(const IdlTypes& types, const std::string& type, ByteView payload);

/// One line, without line end. 64-bit numbers are written whole.
std::string JsonOf(const Value& value);

}  // namespace intaglio::recording
