// Somebody on the network, for the tests of who may command the laser: joins with the
// files that it is given, or with none, and tries one thing until it is killed. It looks
// at nothing itself; what stops it is the DDS library and the others.
//
//   stranger TAG FOLDER|- write TOPIC CELL WORD    WORD: who it says it is
//   stranger TAG FOLDER|- read TOPIC CELL
// And somebody who belongs there, who joins as the services do:
//   stranger TAG FOLDER hear TOPIC CELL            says each WORD and how often
// Says on its standard output what became of it, a line each.

#include <dds/dds.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <iostream>
#include <map>
#include <string>
#include <thread>

#include "services/bus/bus.h"
#include "services/bus/identity.h"
#include "services/bus/qos.h"
#include "services/bus/samples.h"

namespace {

using namespace intaglio::bus;

constexpr dds_domainid_t kDomain = 40;

void Say(const std::string& text) { std::cout << text << std::endl; }

[[noreturn]] void StayRefused(const char* what, dds_return_t code) {
  Say(fmt::format("{} refused: {}", what, dds_strretcode(code)));
  for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
}

dds_entity_t Must(const char* what, dds_entity_t entity) {
  if (entity < 0) StayRefused(what, entity);
  return entity;
}

struct Place {
  dds_entity_t participant = 0;
  std::string cell;
};

dds_entity_t Join(const std::string& tag, const std::string& folder) {
  std::string security;
  if (folder != "-") security = SecurityConfiguration({folder, {}, {}}).value();
  const std::string configuration = fmt::format(
      "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
      "multicast=\"true\"/></Interfaces></General><Discovery><Tag>{}</Tag>"
      "<ParticipantIndex>none</ParticipantIndex><SPDPInterval>500ms</SPDPInterval>"
      "</Discovery>{}</Domain></CycloneDDS>",
      tag, security);
  Must("domain", dds_create_domain(kDomain, configuration.c_str()));
  return Must("participant", dds_create_participant(kDomain, nullptr, nullptr));
}

template <typename T>
dds_entity_t TopicIn(const Place& place, const Topic<T>& topic) {
  return Must("topic", dds_create_topic(place.participant, topic.descriptor, topic.name,
                                        internal::QosOf(topic.profile).get(), nullptr));
}

internal::QosPointer PartitionOf(Scope scope, const std::string& cell) {
  internal::QosPointer qos(dds_create_qos());
  if (scope == Scope::kCell) dds_qset_partition1(qos.get(), cell.c_str());
  return qos;
}

template <typename T>
void Write(const Place& place, const Topic<T>& topic, T sample,
           std::uint64_t T::*number) {
  const dds_entity_t publisher =
      Must("publisher",
           dds_create_publisher(place.participant,
                                PartitionOf(topic.scope, place.cell).get(), nullptr));
  const dds_entity_t writer =
      Must("writer", dds_create_writer(publisher, TopicIn(place, topic),
                                       internal::QosOf(topic.profile).get(), nullptr));
  Say("writes");
  for (std::uint32_t matched = 0;;) {
    if (number != nullptr) ++(sample.*number);
    dds_write(writer, &sample);
    dds_publication_matched_status_t status;
    dds_get_publication_matched_status(writer, &status);
    if (status.current_count != matched) {
      matched = status.current_count;
      Say(fmt::format("matched {}", matched));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

template <typename T>
void Read(const Place& place, const Topic<T>& topic) {
  const dds_entity_t subscriber =
      Must("subscriber",
           dds_create_subscriber(place.participant,
                                 PartitionOf(topic.scope, place.cell).get(), nullptr));
  const dds_entity_t reader =
      Must("reader", dds_create_reader(subscriber, TopicIn(place, topic),
                                       internal::QosOf(topic.profile).get(), nullptr));
  Say("reads");
  for (int count = 0;;) {
    void* samples[1] = {nullptr};
    dds_sample_info_t seen[1];
    while (dds_take(reader, samples, seen, 1, 1) > 0) {
      if (seen[0].valid_data) Say(fmt::format("read {}", ++count));
      dds_return_loan(reader, samples, 1);
      samples[0] = nullptr;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

/// As a service does it. A process joins once in its life: so does each of these.
template <typename T>
void Hear(Bus& bus, const Topic<T>& topic, char* T::*word) {
  Reader<T> reader(bus, topic);
  Say("hears");
  std::map<std::string, int> heard;
  for (;;) {
    const int count = reader.Take([&](const T& sample) { ++heard[sample.*word]; });
    if (count > 0) Say(fmt::format("heard {}", fmt::join(heard, " ")));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

int HearAs(const std::string& tag, const std::string& folder, const std::string& topic,
           const std::string& cell) {
  BusOptions options;
  options.tag = tag;
  options.security = folder;
  options.cell = cell;
  Bus bus(options);
  if (topic == "JobCommand") {
    Hear(bus, kJobCommand, &intaglio_JobCommand::operator_name);
  } else if (topic == "EmergencyStop") {
    Hear(bus, kEmergencyStop, &intaglio_EmergencyStop::source);
  } else if (topic == "Permission") {
    Hear(bus, kPermission, &intaglio_Permission::operator_name);
  } else if (topic == "MotionState") {
    Hear(bus, kMotionState, &intaglio_MotionState::message);
  }
  return 2;
}

int Try(const Place& place, const std::string& verb, const std::string& topic,
        const std::string& word) {
  if (verb == "read" && topic == "JobStatus") Read(place, kJobStatus);
  if (verb == "read" && topic == "JobCommand") Read(place, kJobCommand);
  if (topic == "JobCommand") {
    intaglio_JobCommand sample{};
    sample.sender = Borrow(word);
    sample.job_uid = Borrow(word);
    sample.operator_name = Borrow(word);
    Write(place, kJobCommand, sample, &intaglio_JobCommand::number);
  }
  if (topic == "EmergencyStop") {
    intaglio_EmergencyStop sample{};
    sample.cell = Borrow(place.cell);
    sample.source = sample.reason = Borrow(word);
    Write(place, kEmergencyStop, sample, &intaglio_EmergencyStop::number);
  }
  if (topic == "Permission") {
    intaglio_Permission sample{};
    sample.cell = Borrow(place.cell);
    sample.granted = true;
    sample.job_uid = sample.operator_name = Borrow(word);
    Write(place, kPermission, sample, &intaglio_Permission::number);
  }
  if (topic == "MotionState") {
    intaglio_MotionState sample{};
    sample.cell = Borrow(place.cell);
    sample.message = Borrow(word);
    Write(place, kMotionState, sample, &intaglio_MotionState::tick);
  }
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return 2;
  if (argv[3] == std::string("hear")) return HearAs(argv[1], argv[2], argv[4], argv[5]);
  const Place place{Join(argv[1], argv[2]), argv[5]};
  return Try(place, argv[3], argv[4], argc > 6 ? argv[6] : "");
}
