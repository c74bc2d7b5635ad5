#pragma once

// What scene_maker.h draws of one job.

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/machine/axes_from_glass.h"
#include "services/scene/scene_maker.h"

namespace intaglio::scene {

class JobScene {
 public:
  /// `job`: null when it is not known. `x_mm`: where its block begins in the world.
  JobScene(const std::string& job_uid, const FrozenJob* job, double x_mm, SceneSink sink);

  Status AddPath(const recording::Value& batch, std::uint64_t time_ns);
  Status AddPulses(const recording::Value& batch, std::uint64_t time_ns);
  Status AddAxes(const recording::Value& state, std::uint64_t time_ns);
  Status Finish();
  /// With the next message all is drawn again, into another file.
  void BeginAnew() { begun_ = false; }

  /// That of the block; when it is not known, of a usual one.
  double width_mm() const;
  std::uint64_t drawn_count() const { return drawn_count_; }

 private:
  struct Point {
    Eigen::Vector3f place_mm = Eigen::Vector3f::Constant(NAN);
    std::uint32_t tick = 0;
    std::uint8_t outcome = 0;  // of PulseOutcome; kToCome
  };
  Status Begin(std::uint64_t time_ns);
  /// Plan and made.
  Status WriteClouds(std::uint64_t time_ns);
  Status Write(const char* topic, const google::protobuf::Message& message,
               std::uint64_t time_ns) const;

  std::string frame_;
  SceneSink sink_;
  double x_mm_;
  std::string name_;
  std::optional<Vec3> block_mm_;  // size
  std::optional<machine::AxesFromGlass> axes_from_glass_;
  bool begun_ = false;
  std::vector<Point> points_;  // by their place in the order
  std::uint64_t pulse_count_ = 0, written_pulse_count_ = 0, drawn_count_ = 0;
  std::uint64_t pulse_time_ns_ = 0;         // of the last report
  std::optional<std::uint64_t> axes_ns_{};  // when the beam was drawn
};

}  // namespace intaglio::scene
