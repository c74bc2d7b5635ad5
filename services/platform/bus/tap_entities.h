#pragma once

// The DDS entities of a TopicTap. For services/platform/bus only.

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <unordered_map>

#include "services/platform/bus/topic_tap.h"

struct dds_builtintopic_endpoint;
struct ddsi_typeinfo;

namespace intaglio::bus {

struct TopicTap::Impl {
  /// The reader of one topic of a domain.
  struct Tapped {
    DomainKind domain{};
    std::int32_t participant = 0, reader = 0;
    TapChannel like;  // all but number, partition and QoS
    std::unordered_map<std::uint64_t, std::uint32_t> generation;  // of Take
  };
  struct Domain {
    DomainKind kind{};
    std::int32_t participant = 0, writers = 0;  // writers: built-in topic
    std::int32_t subscriber = 0, unparted = 0;  // of every partition; of none
    std::set<std::string> tapped;
    std::map<std::string, int> tries;  // of topics whose type is not known yet
  };

  Impl(Bus& bus, Filter filter_given, Complaint complaint_given);
  ~Impl();
  void Join(DomainKind kind, int number);
  void Inspect(Domain& domain, const dds_builtintopic_endpoint& writer);
  void MakeReader(Domain& domain, const dds_builtintopic_endpoint& writer,
                  const ddsi_typeinfo* type);
  std::uint32_t ChannelOf(const Tapped& tapped, std::uint64_t writer);
  std::uint32_t FindOrAdd(TapChannel&& channel);
  int TakeFrom(Tapped& tapped, const std::function<void(TapSample&&)>& sink);
  class Delivery;
  void GiveUp(Domain& domain, const std::string& topic, const std::string& why);

  Filter filter;
  Complaint complaint;
  std::array<Domain, 2> domains;
  std::int32_t discovery = 0, arrival = 0, guard = 0;  // wait sets and a condition
  std::unordered_map<std::uint64_t, std::uint32_t> channel_of_writer;  // of Take
  mutable std::mutex mutex;                                            // of what follows
  std::deque<Tapped> readers;
  std::deque<TapChannel> channels;
};

}  // namespace intaglio::bus
