// A stranger on the network, for the tests of who may command the laser: joins with the
// files that it is given, or with none, and tries one thing until it is killed. It checks
// nothing itself: the DDS library and the other processes stop it.
//
//   stranger TAG FOLDER|- write TOPIC CELL WORD    WORD: the name that it uses
//   stranger TAG FOLDER|- read TOPIC CELL
// A participant with a valid identity who abuses it:
//   stranger TAG FOLDER look - CELL     has readers of all that an observer may read
//   stranger TAG FOLDER deaf - CELL     reads all that an observer may; after the first
//                                       health it receives nothing any more, acknowledges
//                                       nothing and stays alive
//   stranger TAG FOLDER forge - CELL    writes health in the name of the job service and
//                                       of the cell's synchronizer, and DONE and FAILED
//                                       of each engraving, in its synchronizer's name;
//                                       FOLDER is that of a stage worker
// A participant that belongs there and joins as the services do:
//   stranger TAG FOLDER hear TOPIC CELL            prints each WORD and how often
// Prints the result on its standard output, a line each.

#include <dds/dds.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <iostream>
#include <map>
#include <string>
#include <thread>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/identity.h"
#include "services/platform/bus/qos.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"

namespace {

using namespace intaglio::bus;

constexpr dds_domainid_t kDomain = 40;

void Send(const std::string& text) { std::cout << text << std::endl; }

[[noreturn]] void StayRefused(const char* what, dds_return_t code) {
  Send(fmt::format("{} refused: {}", what, dds_strretcode(code)));
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

/// `cell`: of a cell topic; of what several roles write, their partition.
internal::QosPointer PartitionOf(Scope scope, const std::string& cell) {
  internal::QosPointer qos(dds_create_qos());
  if (scope != Scope::kShop) dds_qset_partition1(qos.get(), cell.c_str());
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
  Send("writes");
  for (std::uint32_t matched = 0;;) {
    if (number != nullptr) ++(sample.*number);
    dds_write(writer, &sample);
    dds_publication_matched_status_t status;
    dds_get_publication_matched_status(writer, &status);
    if (status.current_count != matched) {
      matched = status.current_count;
      Send(fmt::format("matched {}", matched));
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
  Send("reads");
  for (int count = 0;;) {
    void* samples[1] = {nullptr};
    dds_sample_info_t seen[1];
    while (dds_take(reader, samples, seen, 1, 1) > 0) {
      if (seen[0].valid_data) Send(fmt::format("read {}", ++count));
      dds_return_loan(reader, samples, 1);
      samples[0] = nullptr;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

/// As a service does it. A process joins once in its life: so does each of these.
template <typename T>
void Receive(Bus& bus, const Topic<T>& topic, char* T::*word) {
  Reader<T> reader(bus, topic);
  Send("hears");
  std::map<std::string, int> received;
  for (;;) {
    const int count = reader.Take([&](const T& sample) { ++received[sample.*word]; });
    if (count > 0) Send(fmt::format("heard {}", fmt::join(received, " ")));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

int ReceiveAs(const std::string& tag, const std::string& folder, const std::string& topic,
              const std::string& cell) {
  BusOptions options;
  options.tag = tag;
  options.security = folder;
  options.cell = cell;
  Bus bus(options);
  if (topic == "JobCommand") {
    Receive(bus, kJobCommand, &intaglio_JobCommand::operator_name);
  } else if (topic == "EmergencyStop") {
    Receive(bus, kEmergencyStop, &intaglio_EmergencyStop::source);
  } else if (topic == "Permission") {
    Receive(bus, kPermission, &intaglio_Permission::operator_name);
  } else if (topic == "MotionState") {
    Receive(bus, kMotionState, &intaglio_MotionState::message);
  }
  return 2;
}

template <typename T>
dds_entity_t ReaderOf(const Place& place, const Topic<T>& topic) {
  const dds_entity_t subscriber = Must(
      "subscriber", dds_create_subscriber(place.participant,
                                          PartitionOf(topic.scope, "*").get(), nullptr));
  return Must("reader", dds_create_reader(subscriber, TopicIn(place, topic),
                                          internal::QosOf(topic.profile).get(), nullptr));
}

/// Negative when it is refused.
template <typename T>
dds_entity_t WriterIn(const Place& place, const Topic<T>& topic,
                      const std::string& partition) {
  static std::map<std::string, dds_entity_t> topics;  // one of each in a participant
  dds_entity_t& of_it = topics[topic.name];
  if (of_it == 0) of_it = TopicIn(place, topic);
  const dds_entity_t publisher = dds_create_publisher(
      place.participant, PartitionOf(topic.scope, partition).get(), nullptr);
  return dds_create_writer(publisher, of_it,
                           internal::QosOf(topic.profile, internal::Side::kWriter).get(),
                           nullptr);
}

[[noreturn]] void Read(const Place& place, bool becomes_deaf) {
  const dds_entity_t health = ReaderOf(place, kServiceHealth);
  ReaderOf(place, kTaskStatus);
  ReaderOf(place, kAlarm);
  ReaderOf(place, kJobStatus);
  ReaderOf(place, kPermission);
  ReaderOf(place, kInterlock);
  ReaderOf(place, kPositionReport);
  ReaderOf(place, kPulseEventBatch);
  dds_sample_info_t seen[1];
  for (void* samples[1] = {nullptr}; dds_take(health, samples, seen, 1, 1) <= 0;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::this_thread::sleep_for(std::chrono::seconds(2));  // everybody has matched
  Send(becomes_deaf ? "deaf" : "looks");
  if (becomes_deaf) {
    dds_domain_set_deafmute(place.participant, true, false, DDS_INFINITY);
  }
  for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
}

/// What a stage worker writes in names of others.
class Forger {
 public:
  explicit Forger(const Place& place) : cell_(place.cell) {
    const std::string own = RolePartition(kStageWorkerRole);
    tasks_ = ReaderOf(place, kSortTask);
    health_ = Must("writer", WriterIn(place, kServiceHealth, own));
    status_ = Must("writer", WriterIn(place, kTaskStatus, own));
    for (const std::string& role : {std::string(kJobServiceRole), CellRole(cell_)}) {
      const dds_entity_t writer = WriterIn(place, kServiceHealth, RolePartition(role));
      Send(fmt::format("health of {} {}", role, writer < 0 ? "refused" : "writes"));
    }
    Send("forges");
  }

  [[noreturn]] void Run() {
    for (;;) {
      // The one with the smaller name stays of two that serve one machine.
      Health("a-job-service", intaglio_ROLE_JOB_SERVICE, "");
      Health("a-synchronizer", intaglio_ROLE_SYNCHRONIZER, cell_);
      Health("a-bridge", intaglio_ROLE_MOTION_BRIDGE, cell_);
      TakeTasks();
      if (!synchronizer_.empty()) {
        Health(synchronizer_, intaglio_ROLE_SYNCHRONIZER, cell_);
        Report(intaglio_TASK_DONE);
        Report(intaglio_TASK_FAILED);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

 private:
  void Health(const std::string& instance, intaglio_ServiceRole role,
              const std::string& cell) {
    const std::string empty;
    intaglio_ServiceHealth sample{};
    sample.instance = Borrow(instance);
    sample.role = role;
    sample.state = intaglio_HEALTH_FAULT;
    sample.cell = Borrow(cell);
    sample.host = sample.job_uid = sample.version = sample.message = Borrow(empty);
    (void)dds_write(health_, &sample);
  }
  void TakeTasks() {
    void* samples[1] = {nullptr};
    dds_sample_info_t seen[1];
    while (dds_take(tasks_, samples, seen, 1, 1) > 0) {
      const auto* task = static_cast<const intaglio_StageTask*>(samples[0]);
      if (seen[0].valid_data && !task->revoked) {
        synchronizer_ = View(task->consumer);
        job_ = View(task->job_uid);
        attempt_ = task->attempt;
        Send("forges the engraving of " + job_);
      }
      dds_return_loan(tasks_, samples, 1);
      samples[0] = nullptr;
    }
  }
  void Report(intaglio_TaskState state) {
    const std::string word = "forged";
    intaglio_TaskStatus sample{};
    sample.job_uid = Borrow(job_);
    sample.stage = intaglio_STAGE_ENGRAVE;
    sample.worker = Borrow(synchronizer_);
    sample.part_count = 1;
    sample.attempt = attempt_;
    sample.state = state;
    sample.message = Borrow(word);
    (void)dds_write(status_, &sample);
  }

  std::string cell_, synchronizer_, job_;
  std::uint32_t attempt_ = 0;
  dds_entity_t tasks_ = 0, health_ = 0, status_ = 0;
};

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
    sample.source = sample.operator_name = sample.reason = Borrow(word);
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
  if (argv[3] == std::string("hear"))
    return ReceiveAs(argv[1], argv[2], argv[4], argv[5]);
  const Place place{Join(argv[1], argv[2]), argv[5]};
  if (argv[3] == std::string("look")) Read(place, false);
  if (argv[3] == std::string("deaf")) Read(place, true);
  if (argv[3] == std::string("forge")) Forger(place).Run();
  return Try(place, argv[3], argv[4], argc > 6 ? argv[6] : "");
}
