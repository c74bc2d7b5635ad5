#pragma once

// Messages of a recording as values, by the schemas of their channels.

#include <cstdint>
#include <map>

#include "services/platform/recording/cdr_value.h"
#include "services/platform/recording/idl_types.h"
#include "services/platform/recording/mcap_reader.h"

namespace intaglio::recording {

class MessageDecoder {
 public:
  /// The reader has to outlive the decoder.
  explicit MessageDecoder(const McapReader& reader) : reader_(reader) {}

  /// kUnsupported: another encoding than cdr, or a schema that is not omgidl or not in
  /// the recording. kUnreadable: a schema or a payload that is damaged. Each schema is
  /// parsed once, whatever comes of it.
  Result<Value> Decode(const MessageView& message);

 private:
  const McapReader& reader_;
  std::map<std::uint16_t, Result<IdlTypes>> types_;  // by schema
};

}  // namespace intaglio::recording
