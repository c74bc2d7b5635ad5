#include "engrave/course/speed_law.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::course {
namespace {

/// What can be reached from each node's neighbours: forward, then backward.
std::vector<double> ReachableSpeeds(const Path& path, const SpeedLimits& limits,
                                    std::span<const double> cap_mm_s) {
  const auto& segments = path.segments();
  std::vector<double> v(limits.node_mm_s.begin(), limits.node_mm_s.end());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    v[i] = std::min(v[i], cap_mm_s[i]);
    v[i + 1] = std::min(v[i + 1], cap_mm_s[i]);
  }
  const auto reach = [&](double from_mm_s, std::size_t i) {
    return std::sqrt(from_mm_s * from_mm_s +
                     2 * limits.acceleration_mm_s2[i] * segments[i].length_mm);
  };
  for (std::size_t i = 0; i < segments.size(); ++i)
    v[i + 1] = std::min(v[i + 1], reach(v[i], i));
  for (std::size_t i = segments.size(); i-- > 0;)
    v[i] = std::min(v[i], reach(v[i + 1], i));
  return v;
}

/// Appends the phases of one segment; phases without a duration are left out.
class PhaseWriter {
 public:
  explicit PhaseWriter(SpeedLaw& law) : law_(law) {}

  void Segment(double length_mm, double v0, double v1, double cap, double a) {
    const double peak = std::max(
        {v0, v1, std::min(cap, std::sqrt((v0 * v0 + v1 * v1) / 2 + a * length_mm))});
    const double up_mm = (peak * peak - v0 * v0) / (2 * a);
    const double down_mm = (peak * peak - v1 * v1) / (2 * a);
    const double even_mm = std::max(0.0, length_mm - up_mm - down_mm);
    Add((peak - v0) / a, up_mm, v0, a);
    Add(peak > 0 ? even_mm / peak : 0, even_mm, peak, 0);
    Add((peak - v1) / a, down_mm, peak, -a);
    s_mm_ = begin_mm_ += length_mm;
  }

 private:
  void Add(double duration_s, double length_mm, double v, double a) {
    if (duration_s > 0) law_.phases.push_back({law_.duration_s, s_mm_, v, a});
    law_.duration_s += duration_s;
    s_mm_ += length_mm;
  }

  SpeedLaw& law_;
  double s_mm_ = 0, begin_mm_ = 0;
};

/// The phase at ascending times.
class LawCursor {
 public:
  LawCursor(const SpeedLaw& law, double first_s) : law_(law) {
    const auto behind =
        std::ranges::upper_bound(law.phases, first_s, {}, &Phase::begin_s);
    if (behind != law.phases.begin())
      at_ = static_cast<std::size_t>(behind - law.phases.begin()) - 1;
  }

  double PositionAt(double t_s) {
    if (t_s <= 0) return law_.node_speed_mm_s.front() * t_s;
    if (t_s >= law_.duration_s)
      return law_.length_mm + law_.node_speed_mm_s.back() * (t_s - law_.duration_s);
    const Phase& p = PhaseAt(t_s);
    const double t = t_s - p.begin_s;
    return std::min(p.s_mm + t * (p.v_mm_s + t * p.a_mm_s2 / 2), law_.length_mm);
  }
  double SpeedAt(double t_s) {
    if (t_s <= 0) return law_.node_speed_mm_s.front();
    if (t_s >= law_.duration_s) return law_.node_speed_mm_s.back();
    const Phase& p = PhaseAt(t_s);
    return std::max(0.0, p.v_mm_s + (t_s - p.begin_s) * p.a_mm_s2);
  }

 private:
  const Phase& PhaseAt(double t_s) {
    while (at_ + 1 < law_.phases.size() && t_s >= law_.phases[at_ + 1].begin_s) ++at_;
    return law_.phases[at_];
  }

  const SpeedLaw& law_;
  std::size_t at_ = 0;
};

}  // namespace

SpeedLaw PlanSpeeds(const Path& path, const SpeedLimits& limits) {
  const auto& segments = path.segments();
  Require(limits.node_mm_s.size() == path.node_count() &&
              limits.segment_mm_s.size() == segments.size() &&
              limits.acceleration_mm_s2.size() == segments.size(),
          "{} nodes, {} speeds and {} accelerations for {} segments",
          limits.node_mm_s.size(), limits.segment_mm_s.size(),
          limits.acceleration_mm_s2.size(), segments.size());
  std::vector<double> cap_mm_s(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i)
    cap_mm_s[i] = std::min(segments[i].feed_mm_s, limits.segment_mm_s[i]);
  SpeedLaw law;
  law.node_speed_mm_s = ReachableSpeeds(path, limits, cap_mm_s);
  law.length_mm = path.length_mm();
  law.phases.reserve(3 * segments.size());
  PhaseWriter writer(law);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    writer.Segment(segments[i].length_mm, law.node_speed_mm_s[i],
                   law.node_speed_mm_s[i + 1], cap_mm_s[i], limits.acceleration_mm_s2[i]);
  }
  return law;
}

SpeedLaw PlanSpeeds(const Path& path, std::span<const double> inner_node_mm_s,
                    double acceleration_mm_s2) {
  std::vector<double> nodes{0};
  nodes.insert(nodes.end(), inner_node_mm_s.begin(), inner_node_mm_s.end());
  nodes.push_back(0);
  const std::vector<double> speeds(path.segment_count(), kMaxFeedMmS);
  const std::vector<double> accelerations(path.segment_count(), acceleration_mm_s2);
  return PlanSpeeds(path, {nodes, speeds, accelerations});
}

void AlignBlocks(const Path& path, double period_s, SpeedLaw& law) {
  auto& phases = law.phases;
  auto first = phases.begin();
  double begin_s = 0;  // of the block that begins with `first`
  const auto align = [&](auto end, double slower) {
    const double was_s = first->begin_s;
    for (; first != end; ++first) {
      first->begin_s = begin_s + (first->begin_s - was_s) * slower;
      first->v_mm_s /= slower;
      first->a_mm_s2 /= slower * slower;
    }
  };
  for (std::size_t node = kBlockSegments; node < path.segment_count();
       node += kBlockSegments) {
    // Phases begin at nodes, to the rounding of a sum.
    const double s_mm = path.node_s_mm()[node] - kMinSegmentMm / 2;
    const auto end =
        std::ranges::lower_bound(first, phases.end(), s_mm, {}, &Phase::s_mm);
    const double took_s = end->begin_s - first->begin_s;
    const double whole_s = period_s * std::ceil(took_s / period_s);
    align(end, whole_s / took_s);
    begin_s += whole_s;
  }
  law.duration_s += begin_s - first->begin_s;
  align(phases.end(), 1);
}

std::vector<double> SampleLaw(const SpeedLaw& law, double period_s, double first_s,
                              std::size_t count, double smooth_s) {
  const auto half = static_cast<std::size_t>(std::lround(smooth_s / (2 * period_s)));
  LawCursor cursor(law, first_s - period_s * static_cast<double>(half));
  std::vector<double> s_mm(count + 2 * half);
  for (std::size_t i = 0; i < s_mm.size(); ++i) {
    s_mm[i] = cursor.PositionAt(
        first_s + period_s * (static_cast<double>(i) - static_cast<double>(half)));
  }
  if (half == 0) return s_mm;
  // The sum moves on by one sample; of differences to the first, so that it stays exact.
  std::vector<double> mean_mm(count);
  const std::size_t width = 2 * half + 1;
  double sum_mm = 0;
  for (std::size_t i = 0; i < s_mm.size(); ++i) {
    sum_mm += s_mm[i];
    if (i + 1 < width) continue;
    mean_mm[i + 1 - width] = sum_mm / static_cast<double>(width);
    sum_mm -= s_mm[i + 1 - width];
  }
  return mean_mm;
}

std::vector<double> SampleSpeed(const SpeedLaw& law, double period_s, double first_s,
                                std::size_t count) {
  LawCursor cursor(law, first_s);
  std::vector<double> v_mm_s(count);
  for (std::size_t i = 0; i < count; ++i)
    v_mm_s[i] = cursor.SpeedAt(first_s + period_s * static_cast<double>(i));
  return v_mm_s;
}

}  // namespace intaglio::course
