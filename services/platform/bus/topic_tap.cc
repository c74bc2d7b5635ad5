#include "services/platform/bus/topic_tap.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include <utility>

#include "services/platform/bus/endpoint_qos.h"
#include "services/platform/bus/tap_entities.h"

namespace intaglio::bus {
namespace {

constexpr std::size_t kTakenByTap = 64;
constexpr std::uint32_t kIgnored = ~0u;
constexpr std::size_t kKnownWriters = 10'000;

}  // namespace

TapSample::TapSample(TapSample&& other) noexcept { *this = std::move(other); }

TapSample& TapSample::operator=(TapSample&& other) noexcept {
  std::swap(sample_, other.sample_);
  std::swap(reference_, other.reference_);
  bytes_ = other.bytes_;
  channel_ = other.channel_;
  kind_ = other.kind_;
  source_ns_ = other.source_ns_;
  received_ns_ = other.received_ns_;
  return *this;
}

TapSample::~TapSample() {
  if (sample_ == nullptr) return;
  const ddsrt_iovec_t view{const_cast<std::byte*>(bytes_.data()), bytes_.size()};
  ddsi_serdata_to_ser_unref(reference_, &view);
  ddsi_serdata_unref(sample_);
}

std::uint32_t TopicTap::Impl::FindOrAdd(TapChannel&& channel) {
  const std::lock_guard lock(mutex);
  for (const TapChannel& known : channels) {
    if (known.domain == channel.domain && known.topic == channel.topic &&
        known.partition == channel.partition && known.type == channel.type)
      return known.number;
  }
  channel.number = static_cast<std::uint32_t>(channels.size());
  channels.push_back(std::move(channel));
  return channels.back().number;
}

std::uint32_t TopicTap::Impl::ChannelOf(const Tapped& tapped,
                                        dds_instance_handle_t writer) {
  if (const auto known = channel_of_writer.find(writer); known != channel_of_writer.end())
    return known->second;
  TapChannel channel = tapped.like;
  // The properties of a writer that is already gone cannot be read; its partition is then
  // unknown.
  if (auto* reported = dds_get_matched_publication_data(tapped.reader, writer)) {
    channel.partition = internal::PartitionOf(reported->qos);
    channel.qos = internal::QosText(reported->qos);
    dds_builtintopic_free_endpoint(reported);
  }
  const std::uint32_t number = filter(channel) ? FindOrAdd(std::move(channel)) : kIgnored;
  // Each command that a person types has writers of its own. When full, all entries are
  // removed; those of present writers are read again.
  if (channel_of_writer.size() >= kKnownWriters) channel_of_writer.clear();
  channel_of_writer.emplace(writer, number);
  return number;
}

/// Hands on what one take gave. A sample that was still there when its instance ended
/// represents both, so an end is also recognized by the generation that a sample belongs
/// to.
class TopicTap::Impl::Delivery {
 public:
  Delivery(Impl& tap, Tapped& tapped, const std::function<void(TapSample&&)>& sink)
      : tap_(tap), tapped_(tapped), sink_(sink), now_ns_(dds_time()) {}

  /// Takes over the reference to `bytes`.
  void Deliver(ddsi_serdata* bytes, const dds_sample_info_t& origin) {
    const std::uint32_t channel = tap_.ChannelOf(tapped_, origin.publication_handle);
    const bool ended = tapped_.like.keyed && origin.instance_state != DDS_IST_ALIVE;
    if (channel == kIgnored || (!origin.valid_data && !ended)) {
      ddsi_serdata_unref(bytes);
      return;
    }
    const TapKind end = origin.instance_state == DDS_IST_NOT_ALIVE_DISPOSED
                            ? TapKind::kDisposed
                            : TapKind::kNoWriter;
    if (!origin.valid_data) {
      tapped_.generation.erase(origin.instance_handle);
      HandOver(bytes, end, channel, origin.source_timestamp);
      return;
    }
    if (tapped_.like.keyed) {
      const std::uint32_t generation =
          origin.disposed_generation_count + origin.no_writers_generation_count;
      const auto [known, added] =
          tapped_.generation.try_emplace(origin.instance_handle, generation);
      if (!added && known->second < generation) {
        HandOver(ddsi_serdata_to_untyped(bytes), TapKind::kDisposed, channel,
                 origin.source_timestamp);
      }
      known->second = generation;
      ended_.erase(origin.instance_handle);
      if (ended) {
        ended_.insert_or_assign(
            origin.instance_handle,
            Make(ddsi_serdata_to_untyped(bytes), end, channel, now_ns_));
      }
    }
    HandOver(bytes, TapKind::kValue, channel, origin.source_timestamp);
  }

  /// After the last sample.
  void DeliverEnds() {
    for (auto& [instance, sample] : ended_) {
      tapped_.generation.erase(instance);
      sink_(std::move(sample));
    }
  }

 private:
  TapSample Make(ddsi_serdata* bytes, TapKind kind, std::uint32_t channel,
                 std::int64_t source_ns) const {
    ddsrt_iovec_t view;
    TapSample sample;
    sample.sample_ = bytes;
    sample.reference_ =
        ddsi_serdata_to_ser_ref(bytes, 0, ddsi_serdata_size(bytes), &view);
    sample.bytes_ = {static_cast<const std::byte*>(view.iov_base), view.iov_len};
    sample.channel_ = channel;
    sample.kind_ = kind;
    sample.source_ns_ = source_ns;
    sample.received_ns_ = now_ns_;
    return sample;
  }
  void HandOver(ddsi_serdata* bytes, TapKind kind, std::uint32_t channel,
                std::int64_t source_ns) {
    sink_(Make(bytes, kind, channel, source_ns));
  }

  Impl& tap_;
  Tapped& tapped_;
  const std::function<void(TapSample&&)>& sink_;
  std::int64_t now_ns_;
  std::map<dds_instance_handle_t, TapSample> ended_;
};

int TopicTap::Impl::TakeFrom(Tapped& tapped,
                             const std::function<void(TapSample&&)>& sink) {
  Delivery delivery(*this, tapped, sink);
  int total = 0;
  for (;;) {
    std::array<ddsi_serdata*, kTakenByTap> taken{};
    std::array<dds_sample_info_t, kTakenByTap> origins;
    const auto count = dds_takecdr(tapped.reader, taken.data(), kTakenByTap,
                                   origins.data(), DDS_ANY_STATE);
    for (std::int32_t i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      delivery.Deliver(taken[at], origins[at]);
    }
    total += std::max<int>(0, count);
    if (count < static_cast<std::int32_t>(kTakenByTap)) break;
  }
  delivery.DeliverEnds();
  return total;
}

TopicTap::TopicTap(Bus& bus, Filter filter, Complaint complaint)
    : impl_(std::make_unique<Impl>(bus, std::move(filter), std::move(complaint))) {}
TopicTap::~TopicTap() = default;

int TopicTap::Take(std::chrono::milliseconds timeout,
                   const std::function<void(TapSample&&)>& sink) {
  std::array<dds_attach_t, 64> triggered;
  const auto count = dds_waitset_wait(impl_->arrival, triggered.data(), triggered.size(),
                                      DDS_MSECS(timeout.count()));
  int taken = 0;
  for (std::int32_t i = 0; i < count && i < static_cast<std::int32_t>(triggered.size());
       ++i) {
    const dds_attach_t which = triggered[static_cast<std::size_t>(i)];
    if (which < 0) {
      bool woken = false;
      (void)dds_take_guardcondition(impl_->guard, &woken);
      continue;
    }
    Impl::Tapped* tapped = nullptr;
    {
      const std::lock_guard lock(impl_->mutex);
      tapped = &impl_->readers[static_cast<std::size_t>(which)];
    }
    taken += impl_->TakeFrom(*tapped, sink);
  }
  return taken;
}

std::optional<std::size_t> TopicTap::WriterCount(const std::string& topic) const {
  const std::lock_guard lock(impl_->mutex);
  std::optional<std::size_t> count;
  for (const Impl::Tapped& tapped : impl_->readers) {
    if (tapped.like.topic != topic) continue;
    dds_subscription_matched_status_t matched{};
    if (dds_get_subscription_matched_status(tapped.reader, &matched) == DDS_RETCODE_OK)
      count = count.value_or(0) + matched.current_count;
  }
  return count;
}

void TopicTap::Wake() { (void)dds_set_guardcondition(impl_->guard, true); }

const TapChannel& TopicTap::channel(std::uint32_t number) const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->channels.at(number);
}

std::uint32_t TopicTap::channel_count() const {
  const std::lock_guard lock(impl_->mutex);
  return static_cast<std::uint32_t>(impl_->channels.size());
}

}  // namespace intaglio::bus
