#pragma once

// The version of what a service says on the bus. Two builds of one software version may
// differ in it while the software is worked on; what one of them does not know, it would
// leave out without a word.

#include <cstdint>
#include <string>

namespace google::protobuf {
class FileDescriptor;
}

namespace intaglio::host {

/// The software version, and a checksum over the types of all topics and over the job
/// and the outcomes that they carry: "0.1.0+1f0c66a3". Two services understand each
/// other if theirs are equal.
const std::string& WireVersion();

/// Over the messages of this file and of all that it imports, without their comments.
std::uint32_t ChecksumOf(const google::protobuf::FileDescriptor& file);

}  // namespace intaglio::host
