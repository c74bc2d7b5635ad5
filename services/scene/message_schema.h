#pragma once

// What a Protobuf message needs in an MCAP file: its schema, its topic, its time.

#include <google/protobuf/descriptor.h>
#include <google/protobuf/timestamp.pb.h>

#include <string>

namespace intaglio::scene {

/// The encoding of both a schema and a channel of such messages.
inline constexpr char kProtobuf[] = "protobuf";

/// A serialized FileDescriptorSet with the file of the message and all that it imports,
/// each behind those that it imports itself.
std::string SchemaOf(const google::protobuf::Descriptor& message);

/// Nanoseconds since 1970 as a message has them.
void SetTime(std::uint64_t time_ns, google::protobuf::Timestamp& time);

/// The topic of a message of a scene, in its file.
std::string TopicInFile(const std::string& topic);

}  // namespace intaglio::scene
