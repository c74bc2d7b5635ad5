#pragma once

// The types of a recording, read from the IDL text of its schemas: enough of OMG IDL 4.2
// for what the recorder writes (modules, structs with keys and optional members, enums,
// bounded and unbounded strings and sequences, arrays). kUnsupported for unions,
// inheritance, sequences of sequences, mutable types and type definitions.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::recording {

enum class IdlKind {
  kBoolean,
  kOctet,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble,
  kChar,
  kString,
  kEnum,
  kStruct,
};

struct IdlMember {
  std::string name;
  IdlKind kind = IdlKind::kInt32;  ///< of the element
  std::string type;                ///< qualified name of an enum or struct
  bool sequence = false;
  std::vector<std::uint32_t> dimensions;  ///< of an array
  bool optional = false;
};

struct IdlStruct {
  std::vector<IdlMember> members;
  bool appendable = false;
};

struct IdlEnum {
  std::map<std::int64_t, std::string> names;
  std::uint32_t bit_bound = 32;
};

struct IdlTypes {
  std::map<std::string, IdlStruct> structs;  ///< by qualified name, "module::name"
  std::map<std::string, IdlEnum> enums;
};

/// kUnreadable or kUnsupported with the token at which it stopped. A type has to be
/// defined before it is used.
Result<IdlTypes> ParseIdl(std::string_view text);

}  // namespace intaglio::recording
