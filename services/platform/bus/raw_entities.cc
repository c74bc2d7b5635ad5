#include "services/platform/bus/raw_entities.h"

#include <dds/dds.h>
#include <fmt/format.h>

#include <array>
#include <cstring>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/bus_entities.h"
#include "services/platform/bus/endpoint_qos.h"
#include "services/platform/bus/qos.h"
#include "services/platform/bus/role_names.h"

namespace intaglio::bus {

// Hashes of the complete type are in the XTypes type information.
std::string_view TypeInformationOf(const dds_topic_descriptor& type) {
  const auto& bytes = type.type_information;
  return {reinterpret_cast<const char*>(bytes.data), bytes.sz};
}

namespace internal {
namespace {

constexpr std::size_t kTakeAtOnce = 64;
// A writer that is faster than its reader would keep that for ever; the rest is there for
// the next call.
constexpr int kMaxATake = 16384;
// When full, all entries are removed, also those of writers that are gone; the others are
// read again.
constexpr std::size_t kMaxKnownWriters = 4096;

dds_entity_t Must(dds_entity_t entity, const char* what, const char* topic) {
  if (entity == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) {
    throw NotAllowedError(
        fmt::format("cannot create a {} of {}: the identity's permissions do not allow "
                    "it (see `intaglio security roles`)",
                    what, topic));
  }
  if (entity < 0) {
    throw BusError(
        fmt::format("cannot create a {} of {}: {}", what, topic, dds_strretcode(entity)));
  }
  return entity;
}

/// Cell topics travel in their cell's partition; without a cell a reader sees them all.
void SetCell(dds_qos_t* qos, const Bus::Entities& bus, const std::string& cell) {
  const std::string& own = cell.empty() ? bus.options.cell : cell;
  dds_qset_partition1(qos, own.empty() ? "*" : own.c_str());
}

QosPointer SubscriberQosOf(const Bus::Entities& bus, const TopicView& topic,
                           const std::string& partition) {
  QosPointer qos(dds_create_qos());
  if (topic.scope == Scope::kCell) SetCell(qos.get(), bus, partition);
  if (topic.scope == Scope::kRole && !partition.empty()) {
    dds_qset_partition1(qos.get(), partition.c_str());
  } else if (topic.scope == Scope::kRole) {
    // Partitions of all roles. Without identities also of participants without a role,
    // and of samples played from a recording that is older than these partitions.
    const std::string roles = RolePartition("*");
    const char* all[] = {roles.c_str(), ""};
    dds_qset_partition(qos.get(), bus.security.empty() ? 2 : 1, all);
  }
  return qos;
}

QosPointer PublisherQosOf(const Bus::Entities& bus, const TopicView& topic,
                          const std::string& partition) {
  QosPointer qos(dds_create_qos());
  if (topic.scope == Scope::kCell) SetCell(qos.get(), bus, partition);
  if (topic.scope == Scope::kRole) {
    const std::string own = bus.role.empty() ? "" : RolePartition(bus.role);
    dds_qset_partition1(qos.get(), partition.empty() ? own.c_str() : partition.c_str());
  }
  return qos;
}

}  // namespace

bool IsMatched(std::int32_t writer, const Guid& reader) {
  std::array<dds_instance_handle_t, 256> handles;
  const auto count =
      dds_get_matched_subscriptions(writer, handles.data(), handles.size());
  for (std::int32_t i = 0; i < count && i < static_cast<std::int32_t>(handles.size());
       ++i) {
    dds_builtintopic_endpoint_t* endpoint =
        dds_get_matched_subscription_data(writer, handles[static_cast<std::size_t>(i)]);
    if (endpoint == nullptr) continue;
    const bool same = std::memcmp(endpoint->key.v, reader.data(), reader.size()) == 0;
    dds_builtintopic_free_endpoint(endpoint);
    if (same) return true;
  }
  return false;
}

std::string ParticipantName(const std::uint8_t* guid) {
  constexpr std::size_t kPrefix = 12;  // what is behind it numbers entities
  std::string name;
  for (std::size_t i = 0; i < kPrefix; ++i) name += fmt::format("{:02x}", guid[i]);
  return name;
}

RawReader::RawReader(Bus& bus, const TopicView& topic, const std::string& partition,
                     const ReaderChoice& choice)
    : keyed_(topic.descriptor->m_nkeys > 0) {
  auto& entities = bus.entities();
  const dds_entity_t topic_entity = entities.TopicOf(topic);
  subscriber_ = Must(
      dds_create_subscriber(entities.participant(topic.domain),
                            SubscriberQosOf(entities, topic, partition).get(), nullptr),
      "subscriber", topic.name);
  const QosPointer qos = QosOf(topic.profile);
  if (choice.keep_all) dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  if (choice.others_only) dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PROCESS);
  reader_ = Must(dds_create_reader(subscriber_, topic_entity, qos.get(), nullptr),
                 "reader", topic.name);
  condition_ =
      Must(dds_create_readcondition(reader_, DDS_ANY_STATE), "condition", topic.name);
}

RawReader::~RawReader() { dds_delete(subscriber_); }

const SampleWriter* RawReader::WriterOf(std::uint64_t publication) {
  if (const auto known = writers_.find(publication); known != writers_.end()) {
    return &known->second;
  }
  auto* endpoint = dds_get_matched_publication_data(reader_, publication);
  if (endpoint == nullptr) return nullptr;
  if (writers_.size() >= kMaxKnownWriters) writers_.clear();
  const SampleWriter& writer = writers_[publication] = {
      ParticipantName(endpoint->participant_key.v), internal::PartitionOf(endpoint->qos)};
  dds_builtintopic_free_endpoint(endpoint);
  return &writer;
}

int RawReader::Take(Sink sink, void* context) {
  int total = 0;
  for (;;) {
    std::array<void*, kTakeAtOnce> samples{};
    std::array<dds_sample_info_t, kTakeAtOnce> origins;
    const auto count =
        dds_take(reader_, samples.data(), origins.data(), kTakeAtOnce, kTakeAtOnce);
    if (count <= 0) return total;
    struct Loan {
      dds_entity_t reader;
      void** samples;
      std::int32_t count;
      ~Loan() { (void)dds_return_loan(reader, samples, count); }
    } const loan{reader_, samples.data(), count};
    for (std::int32_t i = 0; i < count; ++i) {
      const dds_sample_info_t& origin = origins[static_cast<std::size_t>(i)];
      void* sample = samples[static_cast<std::size_t>(i)];
      SampleOrigin to_sink{true, origin.source_timestamp, false,
                           WriterOf(origin.publication_handle)};
      // A sample that was still unread when its instance ended carries both.
      if (origin.valid_data) sink(context, sample, to_sink);
      const bool ended = keyed_ && origin.instance_state != DDS_IST_ALIVE;
      if (!ended && origin.valid_data) continue;
      to_sink.alive = false;
      to_sink.disposed = origin.instance_state == DDS_IST_NOT_ALIVE_DISPOSED;
      sink(context, sample, to_sink);
    }
    total += count;
    if (static_cast<std::size_t>(count) < kTakeAtOnce || total >= kMaxATake) return total;
  }
}

ReaderEvents RawReader::events() {
  ReaderEvents events;
  dds_liveliness_changed_status_t liveliness{};
  if (dds_get_liveliness_changed_status(reader_, &liveliness) == DDS_RETCODE_OK) {
    events.alive_writers = static_cast<int>(liveliness.alive_count);
    events.lost_leases = std::max(0, static_cast<int>(liveliness.not_alive_count_change));
  }
  dds_requested_deadline_missed_status_t deadline{};
  if (dds_get_requested_deadline_missed_status(reader_, &deadline) == DDS_RETCODE_OK) {
    events.missed_deadlines = static_cast<int>(deadline.total_count_change);
  }
  return events;
}

int RawReader::matched_count() const {
  dds_subscription_matched_status_t status{};
  (void)dds_get_subscription_matched_status(reader_, &status);
  return static_cast<int>(status.current_count);
}

Guid RawReader::guid() const {
  dds_guid_t guid{};
  (void)dds_get_guid(reader_, &guid);
  Guid bytes;
  static_assert(sizeof guid.v == sizeof bytes);
  std::memcpy(bytes.data(), guid.v, bytes.size());
  return bytes;
}

RawWriter::RawWriter(Bus& bus, const TopicView& topic, const std::string& partition)
    : topic_(topic.name) {
  auto& entities = bus.entities();
  const dds_entity_t topic_entity = entities.TopicOf(topic);
  publisher_ = Must(
      dds_create_publisher(entities.participant(topic.domain),
                           PublisherQosOf(entities, topic, partition).get(), nullptr),
      "publisher", topic.name);
  writer_ = Must(dds_create_writer(publisher_, topic_entity,
                                   QosOf(topic.profile, Side::kWriter).get(), nullptr),
                 "writer", topic.name);
}

RawWriter::~RawWriter() { dds_delete(publisher_); }

Status RawWriter::Answer(std::int32_t code, const char* what) const {
  if (code == DDS_RETCODE_OK) return {};
  return Fail(code == DDS_RETCODE_TIMEOUT ? ErrorCode::kTimedOut : ErrorCode::kIo,
              fmt::format("topic {}: {} failed: {}", topic_, what, dds_strretcode(code)),
              topic_);
}

Status RawWriter::Write(const void* sample) {
  return Answer(dds_write(writer_, sample), "a write");
}

// What is only disposed the library keeps an instance of, here and in every reader.
Status RawWriter::Dispose(const void* sample) {
  const auto disposed = dds_dispose(writer_, sample);
  if (disposed != DDS_RETCODE_OK) return Answer(disposed, "a dispose");
  return Answer(dds_unregister_instance(writer_, sample), "an unregistration");
}

int RawWriter::matched_count() const {
  dds_publication_matched_status_t status{};
  (void)dds_get_publication_matched_status(writer_, &status);
  return static_cast<int>(status.current_count);
}

bool RawWriter::IsMatched(const Guid& reader) const {
  return internal::IsMatched(writer_, reader);
}

Status RawWriter::WaitForAcknowledgements(std::chrono::milliseconds timeout) {
  return Answer(dds_wait_for_acks(writer_, DDS_MSECS(timeout.count())),
                "an acknowledgement");
}

}  // namespace internal
}  // namespace intaglio::bus
