#include "services/scene/job_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "proto/foxglove.pb.h"
#include "services/job/machine/machine_axes.h"
#include "services/scene/message_schema.h"

namespace intaglio::scene {
namespace {

using recording::MemberOf;
using recording::Value;
using Numbers = std::vector<std::uint64_t>;
using Reals = std::vector<double>;

constexpr std::uint8_t kMade = 0, kMissed = 1, kUncertain = 3;  // idl PulseOutcome
constexpr std::uint8_t kToCome = 255;
constexpr double kUsualWidthMm = 50;
constexpr double kGrowth = 1.0 / 20;  // of the plan, between two clouds of what was made
constexpr std::uint64_t kBeamNs = 50'000'000;
constexpr double kBeamAboveMm = 20, kFocusMm = 0.6, kPlateMm = 3, kPlateMarginMm = 10;
/// Batches may be left out, as by --bulk thin. A gap of more points than this is none of
/// ours: the file is damaged, and would fill the memory.
constexpr std::uint64_t kMaxGap = 4'000'000;

struct Rgba {
  std::uint8_t r, g, b, a;
};
// They are seen on light and on dark ground.
constexpr Rgba kPlanColour{150, 155, 165, 255}, kMadeColour{40, 150, 255, 255},
    kMissedColour{255, 150, 40, 255}, kUncertainColour{255, 60, 60, 255};

Rgba ColourOf(std::uint8_t outcome) {
  if (outcome == kMissed) return kMissedColour;
  return outcome == kUncertain ? kUncertainColour : kMadeColour;
}

template <typename Message>  // Vector3 or Point3
void Set(const Vec3& from, Message& to) {
  to.set_x(from.x());
  to.set_y(from.y());
  to.set_z(from.z());
}

void SetPose(const Vec3& centre_mm, foxglove::Pose& pose) {
  Set(centre_mm, *pose.mutable_position());
  pose.mutable_orientation()->set_w(1);
}

void SetColour(double r, double g, double b, double a, foxglove::Color& colour) {
  colour.set_r(r);
  colour.set_g(g);
  colour.set_b(b);
  colour.set_a(a);
}

/// Packs points as viewers read them, by the fields that it declares.
class Packer {
 public:
  Packer(const std::string& frame, std::uint64_t time_ns) {
    SetTime(time_ns, *cloud_.mutable_timestamp());
    cloud_.set_frame_id(frame);
    SetPose(Vec3::Zero(), *cloud_.mutable_pose());
    using Field = foxglove::PackedElementField;
    for (const char* name : {"x", "y", "z"}) Declare(name, Field::FLOAT32, 4);
    for (const char* name : {"red", "green", "blue", "alpha"})
      Declare(name, Field::UINT8, 1);
    for (const char* name : {"order", "tick"}) Declare(name, Field::UINT32, 4);
    cloud_.set_point_stride(stride_);
  }
  void Add(const Eigen::Vector3f& place_mm, const Rgba& colour, std::uint32_t order,
           std::uint32_t tick) {
    std::string& data = *cloud_.mutable_data();
    const std::size_t at = data.size();
    data.resize(at + stride_);
    std::memcpy(&data[at], place_mm.data(), 12);
    std::memcpy(&data[at + 12], &colour, 4);
    std::memcpy(&data[at + 16], &order, 4);
    std::memcpy(&data[at + 20], &tick, 4);
    ++count_;
  }
  const foxglove::PointCloud& cloud() const { return cloud_; }
  std::uint64_t count() const { return count_; }

 private:
  void Declare(const char* name, foxglove::PackedElementField::NumericType type,
               std::uint32_t bytes) {
    foxglove::PackedElementField& field = *cloud_.add_fields();
    field.set_name(name);
    field.set_offset(std::exchange(stride_, stride_ + bytes));
    field.set_type(type);
  }
  foxglove::PointCloud cloud_;
  std::uint32_t stride_ = 0;
  std::uint64_t count_ = 0;
};

foxglove::SceneEntity& AddEntity(const std::string& frame, const char* name,
                                 std::uint64_t time_ns, foxglove::SceneUpdate& update) {
  foxglove::SceneEntity& entity = *update.add_entities();
  SetTime(time_ns, *entity.mutable_timestamp());
  entity.set_frame_id(frame);
  entity.set_id(frame + "/" + name);
  return entity;
}

void AddMetadata(const char* key, const std::string& value,
                 foxglove::SceneEntity& entity) {
  foxglove::KeyValuePair& pair = *entity.add_metadata();
  pair.set_key(key);
  pair.set_value(value);
}

foxglove::LinePrimitive& AddLines(foxglove::SceneEntity& entity) {
  foxglove::LinePrimitive& lines = *entity.add_lines();
  lines.set_type(foxglove::LinePrimitive::LINE_LIST);
  SetPose(Vec3::Zero(), *lines.mutable_pose());
  lines.set_thickness(1);
  lines.set_scale_invariant(true);
  return lines;
}

/// The twelve edges of a box with one corner at the origin.
void AddEdges(const Vec3& size_mm, foxglove::LinePrimitive& lines) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int corner = 0; corner < 8; ++corner) {
      if ((corner >> axis) & 1) continue;
      Vec3 from;
      for (int i = 0; i < 3; ++i) from[i] = ((corner >> i) & 1) ? size_mm[i] : 0;
      Vec3 to = from;
      to[axis] = size_mm[axis];
      Set(from, *lines.add_points());
      Set(to, *lines.add_points());
    }
  }
}

foxglove::SceneUpdate BlockOn(const std::string& frame, const std::string& name,
                              const Vec3& size_mm, std::uint64_t time_ns) {
  foxglove::SceneUpdate update;
  foxglove::SceneEntity& block = AddEntity(frame, "block", time_ns, update);
  AddMetadata("job", name, block);
  foxglove::CubePrimitive& glass = *block.add_cubes();
  SetPose(size_mm / 2, *glass.mutable_pose());
  Set(size_mm, *glass.mutable_size());
  SetColour(0.6, 0.8, 1, 0.08, *glass.mutable_color());
  foxglove::LinePrimitive& edges = AddLines(block);
  AddEdges(size_mm, edges);
  SetColour(0.6, 0.8, 1, 0.6, *edges.mutable_color());
  foxglove::CubePrimitive& plate =
      *AddEntity(frame, "stage", time_ns, update).add_cubes();
  SetPose({size_mm.x() / 2, size_mm.y() / 2, -kPlateMm / 2}, *plate.mutable_pose());
  Set({size_mm.x() + 2 * kPlateMarginMm, size_mm.y() + 2 * kPlateMarginMm, kPlateMm},
      *plate.mutable_size());
  SetColour(0.35, 0.37, 0.4, 1, *plate.mutable_color());
  return update;
}

/// "job-7" of "7-6b01ce7f6907".
std::string FrameOf(const std::string& job_uid) {
  return "job-" + job_uid.substr(0, job_uid.find('-'));
}

std::uint32_t Narrow(std::uint64_t number) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(number, UINT32_MAX));
}

}  // namespace

JobScene::JobScene(const std::string& job_uid, const FrozenJob* job, double x_mm,
                   SceneSink sink)
    : frame_(FrameOf(job_uid)), sink_(std::move(sink)), x_mm_(x_mm), name_(job_uid) {
  if (job == nullptr) return;
  name_ = fmt::format("{} ({})", job->job().name(), job_uid);
  const Vector3& size = job->job().block().size_mm();
  const Vec3 block_mm(size.x(), size.y(), size.z());
  if (!(block_mm.minCoeff() > 0) || !block_mm.allFinite()) return;
  block_mm_ = block_mm;
  axes_from_glass_ = AxesFromGlassOfAny(*job);
}

double JobScene::width_mm() const { return block_mm_ ? block_mm_->x() : kUsualWidthMm; }

Status JobScene::Write(const char* topic, const google::protobuf::Message& message,
                       std::uint64_t time_ns) const {
  return sink_(frame_ + "/" + topic, message, time_ns);
}

Status JobScene::Begin(std::uint64_t time_ns) {
  if (std::exchange(begun_, true)) return {};
  foxglove::FrameTransform frame;
  SetTime(time_ns, *frame.mutable_timestamp());
  frame.set_parent_frame_id("world");
  frame.set_child_frame_id(frame_);
  Set({x_mm_, 0, 0}, *frame.mutable_translation());
  frame.mutable_rotation()->set_w(1);
  INTAGLIO_TRY(Write("frame", frame, time_ns));
  if (block_mm_)
    INTAGLIO_TRY(Write("block", BlockOn(frame_, name_, *block_mm_, time_ns), time_ns));
  return points_.empty() ? Status() : WriteClouds(time_ns);
}

Status JobScene::AddPath(const Value& batch, std::uint64_t time_ns) {
  INTAGLIO_TRY(Begin(time_ns));
  const auto first = MemberOf<std::uint64_t>(batch, "first_index");
  const auto& x = MemberOf<Reals>(batch, "x_mm");
  const auto& y = MemberOf<Reals>(batch, "y_mm");
  const auto& z = MemberOf<Reals>(batch, "z_mm");
  const std::size_t count = std::min({x.size(), y.size(), z.size()});
  if (first > points_.size() + kMaxGap) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: a batch of its path begins at point {}, far behind the {} "
                    "before it: the recording is damaged; `intaglio recording "
                    "info` names what is missing",
                    name_, first, Counted(points_.size(), "point")),
        frame_);
  }
  if (points_.size() < first + count) {
    points_.resize(first + count, {.outcome = kToCome});
  }
  for (std::size_t i = 0; i < count; ++i)
    points_[first + i].place_mm = Vec3(x[i], y[i], z[i]).cast<float>();
  return MemberOf<bool>(batch, "last") ? WriteClouds(time_ns) : Status();
}

Status JobScene::AddPulses(const Value& batch, std::uint64_t time_ns) {
  INTAGLIO_TRY(Begin(time_ns));
  const auto& tick = MemberOf<Numbers>(batch, "tick");
  const auto& point = MemberOf<Numbers>(batch, "point");
  const auto& outcome = MemberOf<Numbers>(batch, "outcome");
  Packer fresh(frame_, time_ns);
  for (std::size_t i = 0; i < std::min({tick.size(), point.size(), outcome.size()});
       ++i) {
    const bool fired =
        outcome[i] == kMade || outcome[i] == kMissed || outcome[i] == kUncertain;
    if (!fired || point[i] >= points_.size()) continue;
    Point& at = points_[point[i]];
    at.tick = Narrow(tick[i]);
    at.outcome = static_cast<std::uint8_t>(outcome[i]);
    if (!at.place_mm.allFinite()) continue;
    fresh.Add(at.place_mm, ColourOf(at.outcome), Narrow(point[i]), at.tick);
  }
  pulse_time_ns_ = time_ns;
  if (fresh.count() == 0) return {};
  pulse_count_ += fresh.count();
  INTAGLIO_TRY(Write("new", fresh.cloud(), time_ns));
  const double grown = static_cast<double>(pulse_count_ - written_pulse_count_);
  if (grown < kGrowth * static_cast<double>(points_.size())) return {};
  return WriteClouds(time_ns);
}

Status JobScene::WriteClouds(std::uint64_t time_ns) {
  Packer plan(frame_, time_ns), made(frame_, time_ns);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& at = points_[i];
    if (!at.place_mm.allFinite()) continue;
    if (at.outcome == kToCome) {
      plan.Add(at.place_mm, kPlanColour, Narrow(i), 0);
    } else {
      made.Add(at.place_mm, ColourOf(at.outcome), Narrow(i), at.tick);
    }
  }
  written_pulse_count_ = pulse_count_;
  drawn_count_ += plan.count() + made.count();
  INTAGLIO_TRY(Write("plan", plan.cloud(), time_ns));
  return made.count() == 0 ? Status() : Write("made", made.cloud(), time_ns);
}

Status JobScene::AddAxes(const Value& state, std::uint64_t time_ns) {
  if (!block_mm_ || !axes_from_glass_) return {};
  if (axes_ns_ && time_ns < *axes_ns_ + kBeamNs) return {};
  axes_ns_ = time_ns;
  const Vec3 axes(MemberOf<double>(state, "x_mm"), MemberOf<double>(state, "y_mm"),
                  MemberOf<double>(state, "z_mm"));
  const Vec3 focus_mm = axes_from_glass_->ToGlass(axes);
  if (!focus_mm.allFinite()) return {};
  foxglove::SceneUpdate update;
  foxglove::SceneEntity& beam = AddEntity(frame_, "beam", time_ns, update);
  AddMetadata("tick", fmt::format("{}", MemberOf<std::uint64_t>(state, "tick")), beam);
  for (int i = 0; i < 3; ++i) {
    const auto name = axes_from_glass_->kinematics().axes().at(std::size_t(i));
    AddMetadata(fmt::format("axis {}, {}", name.name, name.unit_name()).c_str(),
                fmt::format("{:.4f}", axes[i]), beam);
  }
  foxglove::LinePrimitive& line = AddLines(beam);
  Set(focus_mm, *line.add_points());
  Set({focus_mm.x(), focus_mm.y(), std::max(focus_mm.z(), block_mm_->z()) + kBeamAboveMm},
      *line.add_points());
  SetColour(0.3, 1, 0.4, 0.8, *line.mutable_color());
  foxglove::SpherePrimitive& focus = *beam.add_spheres();
  SetPose(focus_mm, *focus.mutable_pose());
  Set(Vec3::Constant(kFocusMm), *focus.mutable_size());
  SetColour(0.3, 1, 0.4, 1, *focus.mutable_color());
  return Write("beam", update, time_ns);
}

Status JobScene::Finish() {
  return pulse_count_ > written_pulse_count_ ? WriteClouds(pulse_time_ns_) : Status();
}

}  // namespace intaglio::scene
