#include "services/job/fields/channels.h"

#include <algorithm>

#include "engrave/core/check.h"
#include "services/job/fields/of_points.h"

namespace intaglio {
namespace {

template <typename Channels>
ChannelMask MaskOf(const Channels& channels) {
  ChannelMask mask = 0;
  for (const std::uint32_t channel : channels) {
    Require(channel >= 1 && channel <= kMaxChannels, "channel {} is outside 1..{}",
            channel, kMaxChannels);
    mask |= MaskOfChannel(channel);
  }
  return mask;
}

ChannelMask MaskOf(const JobSpec& job, const Model& model) {
  return MaskOf(model.channels().empty() ? job.laser().channels() : model.channels());
}

}  // namespace

std::vector<ChannelMask> ChannelsOfModels(const JobSpec& job) {
  std::vector<ChannelMask> masks;
  for (const Model& model : job.models()) masks.push_back(MaskOf(job, model));
  if (masks.empty()) masks.push_back(MaskOf(job.laser().channels()));
  Require(std::find(masks.begin(), masks.end(), 0) == masks.end(),
          "the job's defaults are not filled in");
  return masks;
}

Result<std::vector<ChannelMask>> ChannelsOfPoints(const JobSpec& job,
                                                  std::span<const std::uint32_t> source) {
  const std::vector<ChannelMask> of_models = ChannelsOfModels(job);
  if (DistinctMasks(of_models).size() == 1) {
    return std::vector<ChannelMask>(source.size(), of_models.front());
  }
  return OfPoints(of_models, source);
}

Block BlockOf(const JobSpec& job, const Model& model) {
  Block block = job.block();
  const ChannelMask mask = MaskOf(job, model);
  for (const ChannelBlock& own : job.channel_blocks()) {
    if (!ShareChannel(mask, MaskOfChannel(own.channel()))) continue;
    Vector3& size = *block.mutable_size_mm();
    size.set_x(std::min(size.x(), own.size_mm().x()));
    size.set_y(std::min(size.y(), own.size_mm().y()));
    size.set_z(std::min(size.z(), own.size_mm().z()));
  }
  return block;
}

}  // namespace intaglio
