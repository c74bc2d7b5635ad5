#include "services/platform/bus/bus.h"

#include <dds/dds.h>
#include <fmt/format.h>

#include "services/platform/bus/bus_entities.h"
#include "services/platform/bus/bus_option_error.h"
#include "services/platform/bus/discovery_ports.h"
#include "services/platform/bus/identity.h"
#include "services/platform/bus/library_log.h"
#include "services/platform/bus/qos.h"

namespace intaglio::bus {
namespace {

constexpr int kMaxDomain = 100;
constexpr std::chrono::milliseconds kDiscoveryTime{1500};
constexpr std::chrono::milliseconds kSecureDiscoveryTime{4000};

// Only what differs from the library's defaults; {0} interface, {1} its attributes, {2}
// tag, {3} security. Killed peers are noticed after the lease; discovery repeats often
// enough that a cut network heals within a second. A lost sample, or a retained one for a
// late joiner, is asked for within milliseconds: with the default delays the hand-shake
// of a task took 200 ms. A writer that is deleted waits for readers that have not
// acknowledged, maybe dead ones: 200 ms at most, because a service has several.
// {4} watermarks, {5} heartbeat, {6} the ports and the interval of discovery_ports.h.
constexpr char kConfiguration[] = R"(<CycloneDDS><Domain id="any">
  <General><Interfaces><NetworkInterface name="{0}"{1}/></Interfaces></General>
  <Discovery>{2}
    <ParticipantIndex>none</ParticipantIndex>
    <LeaseDuration>2s</LeaseDuration>{6}
  </Discovery>
  <Internal>
    <MultipleReceiveThreads>false</MultipleReceiveThreads>
    <NackDelay>1ms</NackDelay>
    <AutoReschedNackDelay>10ms</AutoReschedNackDelay>
    <HeartbeatInterval min="2ms" minsched="5ms">{5}</HeartbeatInterval>
    <WriterLingerDuration>200ms</WriterLingerDuration>{4}
  </Internal>{3}
</Domain></CycloneDDS>)";

// On the control domain, what a writer may keep unacknowledged is bounded by its
// history (qos.h), 512 batches of 14 kB at the most, so a reader that acknowledges
// nothing never makes it wait. Bulk keeps the library's own, which fit its sockets.
constexpr char kControlWatermarks[] =
    "<Watermarks><WhcAdaptive>false</WhcAdaptive><WhcHigh>16 MB</WhcHigh></Watermarks>";

// What a writer sends is acknowledged by every participant at each heartbeat, and who
// joins has one for each that it meets: on one computer, where nothing is lost on the
// way, they come less often (docs/decisions.md). On a network a lost sample, as of a
// stop, is asked for as soon as ever.
constexpr char kHeartbeatOnLoopback[] = "50ms", kHeartbeat[] = "10ms";

std::string ConfigurationOf(int domain, const BusOptions& options,
                            const std::string& security, const std::string& discovery) {
  const std::string multicast = options.interface == "lo" ? " multicast=\"true\"" : "";
  const std::string tag =
      options.tag.empty() ? "" : fmt::format("<Tag>{}</Tag>", options.tag);
  return fmt::format(kConfiguration, options.interface, multicast, tag, security,
                     domain == options.control_domain ? kControlWatermarks : "",
                     options.interface == "lo" ? kHeartbeatOnLoopback : kHeartbeat,
                     discovery);
}

/// The identity's part of the configuration; empty without one, on loopback.
std::string SecurityOf(const BusOptions& options, std::chrono::sys_seconds& end,
                       std::string& role) {
  if (options.security.empty()) {
    if (options.interface == "lo") return {};
    throw BusOptionError(
        {ErrorCode::kMissing,
         fmt::format(
             "--interface {}: a network requires an identity, because anybody who "
             "reaches it could command the laser; give --security FOLDER (make "
             "one with `intaglio security new`), or stay on --interface lo",
             options.interface),
         options.interface});
  }
  const auto now =
      std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  const auto identity = ReadIdentity(IdentityFolder(options.security, options.roles),
                                     options.control_domain, now);
  if (!identity) throw BusOptionError(identity.error());
  const auto text = SecurityConfiguration(*identity);
  if (!text) throw BusOptionError(text.error());
  end = identity->not_after;
  role = identity->role;
  KeepLibraryLogShort();
  return *text;
}

struct Domains {
  struct Held {
    dds_entity_t handle = 0;
    int count = 0;
    std::string settings;  ///< the configuration without discovery_ports.h
  };
  std::mutex mutex;
  std::map<int, Held> held;
};

Domains& AllDomains() {
  static Domains domains;
  return domains;
}

dds_entity_t Must(dds_entity_t entity, const std::string& what) {
  if (entity == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) {
    throw NotAllowedError(what + ": the identity's permissions do not allow it");
  }
  if (entity < 0) throw BusError(what + ": " + dds_strretcode(entity));
  return entity;
}

dds_entity_t ParticipantIn(int domain, const BusOptions& options) {
  return Must(
      dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr),
      fmt::format(
          "cannot join DDS domain {} on interface {}: check that the interface is up",
          domain, options.interface));
}

}  // namespace

DomainHold::DomainHold(int domain, const BusOptions& options, const std::string& security)
    : domain_(domain) {
  if (options.control_domain < 0 || options.control_domain >= kMaxDomain) {
    throw BusOptionError({ErrorCode::kInvalidValue,
                          fmt::format("control_domain is {}, allowed are 0..{}",
                                      options.control_domain, kMaxDomain - 1),
                          std::to_string(options.control_domain)});
  }
  if (options.tag.find_first_of("<>&\"") != std::string::npos ||
      options.interface.find_first_of("<>&\"") != std::string::npos) {
    throw BusOptionError({ErrorCode::kInvalidValue,
                          "the DDS tag and interface may not contain < > & or \"",
                          options.tag});
  }
  Domains& domains = AllDomains();
  const std::lock_guard lock(domains.mutex);
  Domains::Held& held = domains.held[domain];
  const std::string settings = ConfigurationOf(domain, options, security, "");
  if (held.count > 0 && held.settings != settings) {
    throw BusError(fmt::format(
        "DDS domain {} is already used in this process with other settings", domain));
  }
  if (held.count == 0) {
    held.settings = settings;
    // One process has one role; where tests have several, the first one's ports count.
    const std::string role = options.roles.empty() ? "" : options.roles.front();
    const std::string discovery =
        internal::DiscoveryPorts(domain, role, options.meets_cells) +
        internal::AnnouncementInterval(role, options.interface == "lo");
    const std::string configuration =
        ConfigurationOf(domain, options, security, discovery);
    held.handle = Must(
        dds_create_domain(static_cast<dds_domainid_t>(domain), configuration.c_str()),
        fmt::format("cannot set up DDS domain {} on interface {}: check that the "
                    "interface exists",
                    domain, options.interface));
  }
  ++held.count;
}

DomainHold::~DomainHold() {
  Domains& domains = AllDomains();
  const std::lock_guard lock(domains.mutex);
  Domains::Held& held = domains.held[domain_];
  if (--held.count == 0) dds_delete(held.handle);
}

Bus::Entities::Entities(const BusOptions& bus_options)
    : options(bus_options),
      role(bus_options.roles.empty() ? std::string() : bus_options.roles.front()),
      security(SecurityOf(bus_options, identity_end, role)),
      control_domain(bus_options.control_domain, bus_options, security),
      control(ParticipantIn(bus_options.control_domain, bus_options)) {}

Bus::Entities::~Entities() {
  if (bulk != 0) dds_delete(bulk);
  dds_delete(control);
}

std::int32_t Bus::Entities::participant(DomainKind kind) {
  if (kind == DomainKind::kControl) return control;
  const std::lock_guard lock(bulk_mutex);
  const int domain = options.control_domain + 1;
  if (!bulk_domain) bulk_domain.emplace(domain, options, security);
  if (bulk == 0) bulk = ParticipantIn(domain, options);
  return bulk;
}

std::int32_t Bus::Entities::TopicOf(const internal::TopicView& view) {
  const std::lock_guard lock(mutex);
  auto& topic = topics[view.name];
  if (topic == 0) {
    topic = Must(dds_create_topic(participant(view.domain), view.descriptor, view.name,
                                  internal::QosOf(view.profile).get(), nullptr),
                 fmt::format("cannot create topic {}", view.name));
  }
  return topic;
}

Bus::Bus(const BusOptions& options) : entities_(std::make_unique<Entities>(options)) {}
Bus::~Bus() = default;
const BusOptions& Bus::options() const { return entities_->options; }

std::chrono::milliseconds Bus::discovery_time() const {
  return entities_->security.empty() ? kDiscoveryTime : kSecureDiscoveryTime;
}

std::chrono::sys_seconds Bus::identity_end() const { return entities_->identity_end; }

const std::string& Bus::role() const { return entities_->role; }

std::string Bus::participant_name() const {
  dds_guid_t guid{};
  Must(dds_get_guid(entities_->control, &guid), "cannot read the participant's GUID");
  return internal::ParticipantName(guid.v);
}

void Bus::Leave(std::chrono::milliseconds duration) {
  const std::lock_guard lock(entities_->bulk_mutex);
  for (const dds_entity_t participant : {entities_->control, entities_->bulk}) {
    if (participant == 0) continue;
    (void)dds_domain_set_deafmute(participant, true, true, DDS_MSECS(duration.count()));
  }
}

struct WaitSet::Impl {
  dds_entity_t wait_set = 0;
  dds_entity_t guard = 0;
};

// A wait set over both domains has to hang on the library itself.
WaitSet::WaitSet(Bus&) : impl_(std::make_unique<Impl>()) {
  impl_->wait_set =
      Must(dds_create_waitset(DDS_CYCLONEDDS_HANDLE), "cannot create a wait set");
  impl_->guard = Must(dds_create_guardcondition(DDS_CYCLONEDDS_HANDLE),
                      "cannot create a guard condition");
  Must(dds_waitset_attach(impl_->wait_set, impl_->guard, 0),
       "cannot attach a guard condition");
}

WaitSet::~WaitSet() {
  dds_delete(impl_->wait_set);
  dds_delete(impl_->guard);
}

void WaitSet::AttachRaw(internal::RawReader& reader) {
  Must(dds_waitset_attach(impl_->wait_set, reader.condition(), 0),
       "cannot attach a reader");
}

bool WaitSet::Wait(std::chrono::milliseconds timeout) {
  dds_attach_t triggered[1];
  const auto count =
      dds_waitset_wait(impl_->wait_set, triggered, 1,
                       DDS_MSECS(std::max<std::int64_t>(0, timeout.count())));
  bool woken = false;
  dds_take_guardcondition(impl_->guard, &woken);
  return count > 0 || woken;
}

void WaitSet::Wake() { dds_set_guardcondition(impl_->guard, true); }

}  // namespace intaglio::bus
