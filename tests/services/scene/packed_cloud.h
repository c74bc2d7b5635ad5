#pragma once

// A foxglove.PointCloud as a viewer reads it: by the fields that it declares.

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "proto/foxglove.pb.h"

namespace intaglio::scene {

struct CloudPoint {
  Vec3 place_mm = Vec3::Zero();
  std::uint32_t order = 0, tick = 0;
  int red = 0, green = 0, blue = 0;
};

inline std::vector<CloudPoint> PointsOfCloud(const foxglove::PointCloud& cloud) {
  std::map<std::string, std::size_t> at;
  for (const auto& field : cloud.fields()) at[field.name()] = field.offset();
  const std::size_t stride = cloud.point_stride();
  EXPECT_EQ(cloud.data().size() % stride, 0u);
  std::vector<CloudPoint> points(cloud.data().size() / stride);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const char* const data = cloud.data().data() + i * stride;
    for (int axis = 0; axis < 3; ++axis) {
      float value = 0;
      std::memcpy(&value, data + at.at(std::string(1, "xyz"[axis])), 4);
      points[i].place_mm[axis] = value;
    }
    std::memcpy(&points[i].order, data + at.at("order"), 4);
    std::memcpy(&points[i].tick, data + at.at("tick"), 4);
    points[i].red = static_cast<unsigned char>(data[at.at("red")]);
    points[i].green = static_cast<unsigned char>(data[at.at("green")]);
    points[i].blue = static_cast<unsigned char>(data[at.at("blue")]);
  }
  return points;
}

}  // namespace intaglio::scene
