#pragma once

// The schema of a Protobuf message as MCAP files carry it.

#include <google/protobuf/descriptor.h>

#include <string>

namespace intaglio::scene {

/// The encoding of both a schema and a channel of such messages.
inline constexpr char kProtobuf[] = "protobuf";

/// A serialized FileDescriptorSet with the file of the message and all that it imports,
/// each behind those that it imports itself.
std::string SchemaOf(const google::protobuf::Descriptor& message);

/// The topic of a message of a scene, in its file.
std::string TopicInFile(const std::string& topic);

}  // namespace intaglio::scene
