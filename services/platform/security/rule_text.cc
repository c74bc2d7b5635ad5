#include "services/platform/security/rule_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <map>

namespace intaglio::security {
namespace {

constexpr char kHead[] = R"(<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_{}.xsd">
)";

// Submessages are protected by the key of each writer, so that only those who may read a
// topic can. On the control topics a mark for each receiver is added: a process that can
// read Permission could otherwise forge one of the job service. The bulk topics do
// without: the marks cost time, and points move nothing.
constexpr char kDomainRule[] = R"(    <domain_rule>
      <domains>{domains}</domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>{kind}</discovery_protection_kind>
      <liveliness_protection_kind>{kind}</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>{kind}</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
)";

std::string DomainList(const std::vector<int>& domains, bus::DomainKind kind) {
  std::string text;
  for (const int domain : domains) {
    text += fmt::format("<id>{}</id>", domain + (kind == bus::DomainKind::kBulk ? 1 : 0));
  }
  return text;
}

std::string Time(std::chrono::sys_seconds time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

/// The topics of one domain, by the partition in which they are allowed.
std::string Criteria(const char* verb, const std::map<std::string, std::string>& topics) {
  std::string text;
  for (const auto& [partition, names] : topics) {
    text += fmt::format(
        "        <{0}>\n          <topics>{1}</topics>\n"
        "          <partitions><partition>{2}</partition></partitions>\n"
        "        </{0}>\n",
        verb, names, partition);
  }
  return text;
}

std::string AllowRule(const Role& role, const std::vector<int>& domains,
                      bus::DomainKind domain) {
  std::map<std::string, std::string> publish, subscribe;
  const auto name = [](const RoleTopic& topic) {
    return fmt::format("<topic>{}</topic>", topic.name);
  };
  for (const RoleTopic& topic : role.writes) {
    if (topic.domain == domain) publish[WritePartition(role, topic)] += name(topic);
  }
  for (const RoleTopic& topic : role.reads) {
    if (topic.domain == domain) subscribe[ReadPartition(role, topic)] += name(topic);
  }
  return fmt::format(
      "      <allow_rule>\n        <domains>{}</domains>\n{}{}      </allow_rule>\n",
      DomainList(domains, domain), Criteria("publish", publish),
      Criteria("subscribe", subscribe));
}

}  // namespace

std::string GovernanceText(const std::vector<int>& domains) {
  std::string text = fmt::format(kHead, "governance") + "  <domain_access_rules>\n";
  for (const bus::DomainKind kind : {bus::DomainKind::kControl, bus::DomainKind::kBulk}) {
    text += fmt::format(kDomainRule, fmt::arg("domains", DomainList(domains, kind)),
                        fmt::arg("kind", kind == bus::DomainKind::kControl
                                             ? "ENCRYPT_WITH_ORIGIN_AUTHENTICATION"
                                             : "ENCRYPT"));
  }
  return text + "  </domain_access_rules>\n</dds>\n";
}

std::string PermissionsText(const Role& role, const std::string& subject,
                            const std::vector<int>& domains, const Validity& validity) {
  std::string text = fmt::format(kHead, "permissions");
  text += fmt::format(
      "  <permissions>\n    <grant name=\"{}\">\n"
      "      <subject_name>{}</subject_name>\n"
      "      <validity><not_before>{}</not_before><not_after>{}</not_after></validity>\n",
      role.name, subject, Time(validity.begin), Time(validity.end));
  text += AllowRule(role, domains, bus::DomainKind::kControl);
  text += AllowRule(role, domains, bus::DomainKind::kBulk);
  return text + "      <default>DENY</default>\n    </grant>\n  </permissions>\n</dds>\n";
}

}  // namespace intaglio::security
