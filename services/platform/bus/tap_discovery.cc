// Discovery: the writers and their topics, and the readers that are made for them.

#include <dds/dds.h>
#include <fmt/format.h>

#include <cstring>
#include <vector>

#include "services/platform/bus/bus_entities.h"
#include "services/platform/bus/endpoint_qos.h"
#include "services/platform/bus/qos.h"
#include "services/platform/bus/tap_entities.h"
#include "services/platform/bus/type_text.h"

namespace intaglio::bus {
namespace {

constexpr int kTypeTries = 10;
constexpr std::size_t kReadAtOnce = 1024;

dds_entity_t Must(dds_entity_t entity, const char* what) {
  if (entity < 0)
    throw BusError(fmt::format("cannot make {}: {}", what, dds_strretcode(entity)));
  return entity;
}

/// Readers that see every partition, also none.
internal::QosPointer EveryPartition() {
  internal::QosPointer qos(dds_create_qos());
  const char* partitions[] = {"", "*"};
  dds_qset_partition(qos.get(), 2, partitions);
  return qos;
}

internal::QosPointer ReaderQosFor(const dds_qos_t* writer) {
  internal::QosPointer qos(dds_create_qos());
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_duration_t blocking = 0;
  (void)dds_qget_reliability(writer, &reliability, &blocking);
  (void)dds_qget_durability(writer, &durability);
  dds_qset_reliability(qos.get(), reliability, DDS_MSECS(100));
  dds_qset_durability(qos.get(), durability);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  return qos;
}

/// The library (0.10.2) marks the keys of every discovered type with a string key as
/// fixed and short, and writes longer ones past the end of their storage. Without the
/// mark it handles all of them.
void AdmitLongKeys(dds_topic_descriptor_t& descriptor) {
  const std::uint32_t flags =
      descriptor.m_flagset & ~(DDS_TOPIC_FIXED_KEY | DDS_TOPIC_FIXED_KEY_XCDR2);
  std::memcpy(const_cast<std::uint32_t*>(&descriptor.m_flagset), &flags, sizeof flags);
}

}  // namespace

TopicTap::Impl::Impl(Bus& bus, Filter filter_given, Complaint complaint_given)
    : filter(std::move(filter_given)), complaint(std::move(complaint_given)) {
  discovery = Must(dds_create_waitset(DDS_CYCLONEDDS_HANDLE), "a wait set");
  arrival = Must(dds_create_waitset(DDS_CYCLONEDDS_HANDLE), "a wait set");
  guard = Must(dds_create_guardcondition(DDS_CYCLONEDDS_HANDLE), "a guard condition");
  Must(dds_waitset_attach(arrival, guard, -1), "an attachment");
  for (const DomainKind kind : {DomainKind::kControl, DomainKind::kBulk}) {
    (void)bus.entities().participant(kind);  // sets the domain up
    Join(kind, bus.options().control_domain + (kind == DomainKind::kBulk ? 1 : 0));
  }
}

TopicTap::Impl::~Impl() {
  dds_delete(discovery);
  dds_delete(arrival);
  dds_delete(guard);
  for (const Domain& domain : domains) dds_delete(domain.participant);
}

// A participant of its own: the topics of the process's other readers have the same names
// and would conflict with those made from discovered types.
void TopicTap::Impl::Join(DomainKind kind, int number) {
  Domain& domain = domains[kind == DomainKind::kControl ? 0 : 1];
  domain.kind = kind;
  domain.participant =
      Must(dds_create_participant(static_cast<dds_domainid_t>(number), nullptr, nullptr),
           "a participant");
  domain.subscriber =
      Must(dds_create_subscriber(domain.participant, EveryPartition().get(), nullptr),
           "a subscriber");
  domain.unparted =
      Must(dds_create_subscriber(domain.participant, nullptr, nullptr), "a subscriber");
  domain.writers =
      Must(dds_create_reader(domain.participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                             nullptr, nullptr),
           "a reader of writers");
  const dds_entity_t news =
      Must(dds_create_readcondition(domain.writers, DDS_NOT_READ_SAMPLE_STATE |
                                                        DDS_ANY_VIEW_STATE |
                                                        DDS_ANY_INSTANCE_STATE),
           "a condition");
  Must(dds_waitset_attach(discovery, news, 0), "an attachment");
}

void TopicTap::Impl::GiveUp(Domain& domain, const std::string& topic,
                            const std::string& why) {
  domain.tries.erase(topic);
  domain.tapped.insert(topic);
  complaint(topic, why);
}

void TopicTap::Impl::Inspect(Domain& domain, const dds_builtintopic_endpoint_t& writer) {
  const std::string topic = writer.topic_name;
  // Writers of Presence wait for its readers.
  if (topic.starts_with("DCPS") || topic == kPresence.name ||
      domain.tapped.contains(topic))
    return;
  TapChannel like;
  like.domain = domain.kind;
  like.topic = topic;
  like.type = writer.type_name;
  like.partition = internal::PartitionOf(writer.qos);
  if (!filter(like)) return;
  const dds_typeinfo_t* type = nullptr;
  const auto reported = dds_builtintopic_get_endpoint_type_info(
      const_cast<dds_builtintopic_endpoint_t*>(&writer), &type);
  // Writers of this process do not announce their type, nor do those of a very old
  // library; another writer of the topic may.
  if (reported != DDS_RETCODE_OK || type == nullptr) return;
  MakeReader(domain, writer, type);
}

void TopicTap::Impl::MakeReader(Domain& domain, const dds_builtintopic_endpoint_t& writer,
                                const dds_typeinfo_t* type) {
  const std::string topic = writer.topic_name;
  dds_topic_descriptor_t* made = nullptr;
  const auto resolved = dds_create_topic_descriptor(
      DDS_FIND_SCOPE_GLOBAL, domain.participant, type, internal::kTypeTimeoutNs, &made);
  if (resolved != DDS_RETCODE_OK) {
    if (++domain.tries[topic] >= kTypeTries) {
      GiveUp(domain, topic,
             fmt::format("its type {} is not available: {}", writer.type_name,
                         dds_strretcode(resolved)));
    }
    return;
  }
  const std::unique_ptr<dds_topic_descriptor_t, void (*)(dds_topic_descriptor_t*)>
      descriptor(made,
                 [](dds_topic_descriptor_t* d) { (void)dds_delete_topic_descriptor(d); });
  AdmitLongKeys(*made);
  const dds_entity_t entity = dds_create_topic(domain.participant, descriptor.get(),
                                               writer.topic_name, nullptr, nullptr);
  const auto read = [&](dds_entity_t subscriber) {
    return entity < 0 ? entity
                      : dds_create_reader(subscriber, entity,
                                          ReaderQosFor(writer.qos).get(), nullptr);
  };
  dds_entity_t reader = read(domain.subscriber);
  // Identities may read the topics of the shop in no partition only.
  if (reader == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) reader = read(domain.unparted);
  if (reader < 0) {
    GiveUp(domain, topic, fmt::format("no reader of it: {}", dds_strretcode(reader)));
    return;
  }
  Tapped tapped{domain.kind, domain.participant, reader, {}, {}};
  tapped.like.domain = domain.kind;
  tapped.like.topic = topic;
  tapped.like.type = writer.type_name;
  tapped.like.keyed = descriptor->m_nkeys > 0;
  tapped.like.recipe = internal::RecipeOf(*descriptor);
  if (auto text = internal::TextOf(domain.participant, type)) {
    tapped.like.idl = std::move(text->idl);
    tapped.like.key_idl = std::move(text->key_idl);
  }
  domain.tries.erase(topic);
  domain.tapped.insert(topic);
  const std::lock_guard lock(mutex);
  readers.push_back(std::move(tapped));
  const dds_entity_t condition = dds_create_readcondition(reader, DDS_ANY_STATE);
  (void)dds_waitset_attach(arrival, condition,
                           static_cast<dds_attach_t>(readers.size() - 1));
}

void TopicTap::Discover(std::chrono::milliseconds timeout) {
  dds_attach_t triggered[2];
  (void)dds_waitset_wait(impl_->discovery, triggered, 2, DDS_MSECS(timeout.count()));
  for (Impl::Domain& domain : impl_->domains) {
    // Writers that are gone are removed; the others are checked again while the type of
    // one of them is not known.
    constexpr std::uint32_t kGone = DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE |
                                    DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE |
                                    DDS_NOT_ALIVE_NO_WRITERS_INSTANCE_STATE;
    const std::uint32_t there =
        (domain.tries.empty() ? DDS_NOT_READ_SAMPLE_STATE : DDS_ANY_SAMPLE_STATE) |
        DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE;
    for (const bool take : {true, false}) {
      std::vector<void*> samples(kReadAtOnce);
      std::vector<dds_sample_info_t> origins(samples.size());
      const auto count =
          take ? dds_take_mask(domain.writers, samples.data(), origins.data(),
                               samples.size(), static_cast<std::uint32_t>(samples.size()),
                               kGone)
               : dds_read_mask(domain.writers, samples.data(), origins.data(),
                               samples.size(), static_cast<std::uint32_t>(samples.size()),
                               there);
      for (std::int32_t i = 0; i < count && !take; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!origins[at].valid_data) continue;
        impl_->Inspect(domain,
                       *static_cast<const dds_builtintopic_endpoint_t*>(samples[at]));
      }
      if (count > 0) (void)dds_return_loan(domain.writers, samples.data(), count);
    }
  }
}

}  // namespace intaglio::bus
