#include "services/platform/host/version/wire_version.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.pb.h>

#include <cstdint>
#include <set>
#include <string_view>

#include "proto/task.pb.h"
#include "services/platform/bus/topics.h"
#include "services/platform/host/version/software_version.h"

namespace intaglio::host {
namespace {

// FNV-1a, 32 bits.
class Checksum {
 public:
  void Add(std::string_view bytes) {
    for (const char byte : bytes)
      value_ = (value_ ^ static_cast<unsigned char>(byte)) * 0x01000193u;
  }
  std::uint32_t value() const { return value_; }

 private:
  std::uint32_t value_ = 0x811c9dc5u;
};

void AddTopics(Checksum& checksum) {
  bus::ForEveryTopic([&checksum](const auto& topic) {
    checksum.Add(topic.name);
    checksum.Add(bus::TypeInformationOf(*topic.descriptor));
  });
}

// Comments are not in a descriptor. Protobuf's own files are left out: hosts may have
// other versions of it.
void AddFile(const google::protobuf::FileDescriptor& file, std::set<std::string>& added,
             Checksum& checksum) {
  if (file.package() == "google.protobuf") return;
  if (!added.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i)
    AddFile(*file.dependency(i), added, checksum);
  google::protobuf::FileDescriptorProto content;
  file.CopyTo(&content);
  checksum.Add(content.SerializeAsString());
}

std::string Make() {
  Checksum checksum;
  AddTopics(checksum);
  const std::uint32_t all =
      checksum.value() ^ ChecksumOf(*FrozenJob::descriptor()->file());
  return fmt::format("{}+{:08x}", SoftwareVersion(), all);
}

}  // namespace

std::uint32_t ChecksumOf(const google::protobuf::FileDescriptor& file) {
  Checksum checksum;
  std::set<std::string> added;
  AddFile(file, added, checksum);
  return checksum.value();
}

const std::string& WireVersion() {
  static const std::string version = Make();
  return version;
}

}  // namespace intaglio::host
