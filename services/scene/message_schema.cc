#include "services/scene/message_schema.h"

#include <google/protobuf/descriptor.pb.h>

#include <set>

namespace intaglio::scene {
namespace {

namespace pb = google::protobuf;

void Add(const pb::FileDescriptor& file, std::set<std::string>& added,
         pb::FileDescriptorSet& set) {
  if (!added.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) Add(*file.dependency(i), added, set);
  file.CopyTo(set.add_file());
}

}  // namespace

std::string SchemaOf(const pb::Descriptor& message) {
  pb::FileDescriptorSet set;
  std::set<std::string> added;
  Add(*message.file(), added, set);
  return set.SerializeAsString();
}

void SetTime(std::uint64_t time_ns, google::protobuf::Timestamp& time) {
  time.set_seconds(static_cast<std::int64_t>(time_ns / 1'000'000'000));
  time.set_nanos(static_cast<std::int32_t>(time_ns % 1'000'000'000));
}

std::string TopicInFile(const std::string& topic) { return "/" + topic; }

}  // namespace intaglio::scene
