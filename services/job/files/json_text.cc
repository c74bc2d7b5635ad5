#include "services/job/files/json_text.h"

#include <google/protobuf/util/json_util.h>

namespace intaglio {

Result<std::string> JsonTextOf(const google::protobuf::Message& message,
                               JsonLayout layout) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = layout == JsonLayout::kLines;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto printed =
      google::protobuf::util::MessageToJsonString(message, &json, options);
  if (printed.ok()) return json;
  return Fail(ErrorCode::kInvalidValue, printed.ToString());
}

}  // namespace intaglio
