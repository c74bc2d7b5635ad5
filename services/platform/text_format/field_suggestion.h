#pragma once

#include <google/protobuf/descriptor.h>

#include <optional>
#include <string>
#include <string_view>

namespace intaglio {

/// The field of the message that `name` probably means; none: no name is near.
std::optional<std::string> NearestField(const google::protobuf::Descriptor& type,
                                        std::string_view name);

/// " Did you mean glass?" after what a parser of protobuf's text or JSON format reports
/// of a message of type `root`; "" unless it is about an unknown field.
std::string SuggestionFor(const google::protobuf::Descriptor& root,
                          const std::string& parser_message);

}  // namespace intaglio
