#include "services/platform/bus/cdr_writer.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_protocol.h>
#include <fmt/format.h>

#include <deque>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/bus/bus_entities.h"
#include "services/platform/bus/endpoint_qos.h"
#include "services/platform/bus/qos.h"

namespace intaglio::bus {
namespace {

/// What the library is given: bytes and nothing else. It makes a sample of the topic's
/// own type from them, checking every length (ddsi_serdata_ref_as_type).
struct RawSample {
  ddsi_serdata head;
  std::span<const std::byte> bytes;
};

std::span<const std::byte> BytesOf(const ddsi_serdata* sample) {
  return reinterpret_cast<const RawSample*>(sample)->bytes;
}

std::uint32_t SizeOf(const ddsi_serdata* sample) {
  return static_cast<std::uint32_t>(BytesOf(sample).size());
}

ddsi_serdata* RefBytes(const ddsi_serdata* sample, std::size_t offset, std::size_t size,
                       ddsrt_iovec_t* view) {
  view->iov_base = const_cast<std::byte*>(BytesOf(sample).data() + offset);
  view->iov_len = size;
  return ddsi_serdata_ref(sample);
}

void UnrefBytes(ddsi_serdata* sample, const ddsrt_iovec_t*) {
  ddsi_serdata_unref(sample);
}

void Free(ddsi_serdata* sample) { delete reinterpret_cast<RawSample*>(sample); }

const ddsi_serdata_ops& RawOps() {
  static const ddsi_serdata_ops ops = [] {
    ddsi_serdata_ops made{};
    made.get_size = SizeOf;
    made.to_ser_ref = RefBytes;
    made.to_ser_unref = UnrefBytes;
    made.free = Free;
    return made;
  }();
  return ops;
}

const ddsi_sertype& RawType() {
  static const ddsi_sertype_ops type_ops = [] {
    ddsi_sertype_ops made{};
    made.version = ddsi_sertype_v0;
    return made;
  }();
  static const ddsi_sertype type = [] {
    ddsi_sertype made{};
    made.ops = &type_ops;
    made.serdata_ops = &RawOps();
    return made;
  }();
  return type;
}

std::vector<std::string> PartitionsOf(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    names.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return names;
}

internal::QosPointer PublisherQosOf(const CdrTopic& topic) {
  internal::QosPointer qos(dds_create_qos());
  const auto names = PartitionsOf(topic.partition);
  std::vector<const char*> pointers;
  for (const std::string& name : names) pointers.push_back(name.c_str());
  if (!names.empty()) {
    dds_qset_partition(qos.get(), static_cast<std::uint32_t>(pointers.size()),
                       pointers.data());
  }
  return qos;
}

dds_entity_t Allowed(dds_entity_t entity, const std::string& what) {
  if (entity == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) {
    throw NotAllowedError(what + ": the identity's permissions do not allow it");
  }
  return entity;
}

}  // namespace

CdrWriter::~CdrWriter() { dds_delete(publisher_); }

Status CdrWriter::Write(CdrKind kind, std::span<const std::byte> cdr,
                        std::int64_t source_ns) {
  auto* sample = new RawSample{};
  ddsi_serdata_init(&sample->head, &RawType(),
                    kind == CdrKind::kValue ? SDK_DATA : SDK_KEY);
  sample->bytes = cdr;
  sample->head.timestamp.v = source_ns;
  sample->head.statusinfo = kind == CdrKind::kValue ? 0u
                            : kind == CdrKind::kDisposed
                                ? unsigned{NN_STATUSINFO_DISPOSE}
                                : unsigned{NN_STATUSINFO_UNREGISTER};
  const auto code = dds_forwardcdr(writer_, &sample->head);  // takes the sample over
  if (code == DDS_RETCODE_OK) return {};
  if (code == DDS_RETCODE_TIMEOUT)
    return Fail(ErrorCode::kTimedOut,
                fmt::format("{}: its readers do not keep up", name_));
  return Fail(ErrorCode::kUnreadable,
              fmt::format("a sample of {} is refused: {}", name_, dds_strretcode(code)));
}

int CdrWriter::matched_count() const {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(writer_, &status) == DDS_RETCODE_OK
             ? static_cast<int>(status.current_count)
             : 0;
}

bool CdrWriter::IsMatched(const Guid& reader) const {
  return internal::IsMatched(writer_, reader);
}

Status CdrWriter::WaitForAcknowledgements(std::chrono::milliseconds timeout) {
  if (dds_wait_for_acks(writer_, DDS_MSECS(timeout.count())) == DDS_RETCODE_OK) return {};
  return Fail(ErrorCode::kTimedOut,
              fmt::format("not all readers have acknowledged {}", name_));
}

struct CdrPublisher::Parts {
  std::map<DomainKind, dds_entity_t> participants;
  std::map<std::pair<DomainKind, std::string>, dds_entity_t> topics;
  std::deque<RecipeDescriptor> types;  // the library does not copy all of them
};

CdrPublisher::CdrPublisher(Bus& bus) : parts_(std::make_unique<Parts>()) {
  const int control = bus.options().control_domain;
  for (const auto& [kind, number] :
       {std::pair(DomainKind::kControl, control), {DomainKind::kBulk, control + 1}}) {
    (void)bus.entities().participant(kind);  // sets the domain up
    const dds_entity_t made =
        dds_create_participant(static_cast<dds_domainid_t>(number), nullptr, nullptr);
    if (made < 0) {
      for (const auto& [other, entity] : parts_->participants) dds_delete(entity);
      throw BusError(
          fmt::format("cannot join DDS domain {}: {}", number, dds_strretcode(made)));
    }
    parts_->participants[kind] = made;
  }
}

CdrPublisher::~CdrPublisher() {
  for (const auto& [kind, participant] : parts_->participants) dds_delete(participant);
}

Result<std::unique_ptr<CdrWriter>> CdrPublisher::MakeWriter(const CdrTopic& topic,
                                                            const TypeRecipe& recipe) {
  auto type = INTAGLIO_TRY(RecipeDescriptor::Parse(recipe));
  parts_->types.push_back(std::move(type));
  const auto refused = [&topic](dds_entity_t code) {
    return Fail(ErrorCode::kUnsupported, fmt::format("{} cannot be written: {}",
                                                     topic.name, dds_strretcode(code)));
  };
  const std::string what = "cannot write " + topic.name;
  const dds_entity_t participant = parts_->participants.at(topic.domain);
  const auto qos = internal::WriterQosOf(topic.qos);
  // Each topic has one type, that of the first writer.
  auto& entity = parts_->topics[{topic.domain, topic.name}];
  if (entity <= 0) {
    entity = Allowed(dds_create_topic(participant, &parts_->types.back().descriptor(),
                                      topic.name.c_str(), nullptr, nullptr),
                     what);
  }
  if (entity < 0) return refused(entity);
  const dds_entity_t publisher =
      dds_create_publisher(participant, PublisherQosOf(topic).get(), nullptr);
  if (publisher < 0) return refused(publisher);
  const dds_entity_t writer = dds_create_writer(publisher, entity, qos.get(), nullptr);
  if (writer < 0) {
    dds_delete(publisher);
    return refused(Allowed(writer, what));
  }
  return std::unique_ptr<CdrWriter>(new CdrWriter(topic.name, publisher, writer));
}

}  // namespace intaglio::bus
