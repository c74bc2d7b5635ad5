#pragma once

// The table of methods of discretization: one row for each member of Model.method. Its
// rows lie by what they read: mesh_methods.cc, drawing_methods.cc, picture_methods.cc.

#include <google/protobuf/message.h>

#include <span>
#include <string_view>
#include <vector>

#include "services/job/methods/method.h"

namespace intaglio {

/// In the order of the schema.
std::span<const Method> Methods();

/// nullptr: there is no such method.
const Method* FindMethod(std::string_view name);

/// nullptr for clouds of points, which are taken as they are.
const Method* DefaultMethodOf(ModelKind kind);

/// The method that a Model or a Discretization has; nullptr when it has none.
const Method* MethodOf(const google::protobuf::Message& holder);

/// Its field in Discretization, which methods of meshes have; nullptr for others.
const google::protobuf::FieldDescriptor* FieldInDiscretization(const Method& method);

/// The message of the method in a Model or a Discretization; its defaults when that does
/// not have this method. Precondition: such a holder can have it.
const google::protobuf::Message& MessageOf(const Method& method,
                                           const google::protobuf::Message& holder);

/// The same to write to; the holder then has this method.
google::protobuf::Message& MutableMessageOf(const Method& method,
                                            google::protobuf::Message& holder);

/// Parts of the table, in method_table.cc put together.
std::vector<Method> MeshMethods();
std::vector<Method> DrawingMethods();
std::vector<Method> PictureMethods();

}  // namespace intaglio
