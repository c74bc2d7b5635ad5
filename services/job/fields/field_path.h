#pragma once

// A field of a message by its path and a value as text, as a person writes them into a
// table or a batch: "block.margin_mm" and "5".
//
// A path is names and indices: models[0].placement.move_mm.x. An index has to be there.
// Values: numbers; true and false; texts as they are; names of an enumeration, whole or
// without what all of them begin with, in any case ("x" for AXIS_X); of a Vector3 three
// numbers; of a list all its numbers, of one of places all numbers of the first, then of
// the second, and so on (halftone.curve: "0 0.2 1 0.8"). Blanks, commas or semicolons
// separate them. A group of fields takes "true", which chooses it (ordering.kdz). Ranges
// are not checked.

#include <google/protobuf/message.h>

#include <string>
#include <string_view>

#include "engrave/core/result.h"

namespace intaglio {

/// Whether the path begins with a field of the type.
bool BeginsWithField(const google::protobuf::Descriptor& type, std::string_view path);

/// Errors name path, value and what there is instead: kNotFound (no such field or
/// element), kInvalidValue. The message is then as it was, or has empty groups more.
Status SetField(google::protobuf::Message& message, std::string_view path,
                std::string_view text);

/// Whether what SetField set is still there: another field of the same choice takes the
/// place of the first. Precondition: SetField was good.
bool IsSet(const google::protobuf::Message& message, std::string_view path);

}  // namespace intaglio
