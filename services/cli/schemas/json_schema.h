#pragma once

// JSON Schemas (draft 2020-12) of messages as the commands write them (JsonTextOf:
// names as in the .proto, fields without a value too), from their descriptors; comments
// of the .proto are the descriptions.

#include <google/protobuf/descriptor.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace intaglio::schemas {

/// A JSON value whose members keep their order.
struct Json {
  using Members = std::vector<std::pair<std::string, Json>>;
  std::variant<bool, double, std::string, std::vector<Json>, Members> held;

  /// Two spaces for each level, short lists of texts on one line.
  std::string Text(int level = 0) const;
};

enum class Fields {
  kWritten,  ///< those that are always written are required
  kRead,     ///< none is required: a file that people write
};

struct Schema {
  std::string name;   ///< of the file: NAME.schema.json
  std::string title;  ///< what it is of
  const google::protobuf::Descriptor* message = nullptr;
  Fields fields = Fields::kWritten;
};

/// The schema of one message as the whole text.
Json SchemaOf(const Schema& schema);

/// A glass of `materials --json`: an object of messages, that of the focus only alone; as
/// the element of a list.
Json GlassSchema(const std::string& name, const std::string& title,
                 const google::protobuf::Descriptor& material,
                 const google::protobuf::Descriptor& optics,
                 const google::protobuf::Descriptor* focus, bool list);

}  // namespace intaglio::schemas
