#include "services/platform/host/version/wire_version.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.pb.h>

#include <cstdint>
#include <set>
#include <span>
#include <string_view>

#include "engrave/io/crc32.h"
#include "proto/task.pb.h"
#include "services/platform/bus/topics.h"
#include "services/platform/host/version/software_version.h"

namespace intaglio::host {
namespace {

void Add(std::string_view bytes, std::uint32_t& checksum) {
  checksum = io::Crc32(std::as_bytes(std::span(bytes)), checksum);
}

void AddTopics(std::uint32_t& checksum) {
  bus::ForEveryTopic([&checksum](const auto& topic) {
    Add(topic.name, checksum);
    Add(bus::TypeInformationOf(*topic.descriptor), checksum);
  });
}

// Comments are not in a descriptor. Protobuf's own files are left out: hosts may have
// other versions of it.
void AddFile(const google::protobuf::FileDescriptor& file, std::set<std::string>& added,
             std::uint32_t& checksum) {
  if (file.package() == "google.protobuf") return;
  if (!added.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i)
    AddFile(*file.dependency(i), added, checksum);
  google::protobuf::FileDescriptorProto content;
  file.CopyTo(&content);
  Add(content.SerializeAsString(), checksum);
}

std::string Make() {
  std::uint32_t checksum = ChecksumOf(*FrozenJob::descriptor()->file());
  AddTopics(checksum);
  return fmt::format("{}+{:08x}", SoftwareVersion(), checksum);
}

}  // namespace

std::uint32_t ChecksumOf(const google::protobuf::FileDescriptor& file) {
  std::uint32_t checksum = 0;
  std::set<std::string> added;
  AddFile(file, added, checksum);
  return checksum;
}

const std::string& WireVersion() {
  static const std::string version = Make();
  return version;
}

}  // namespace intaglio::host
