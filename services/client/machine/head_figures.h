#pragma once

// The figures of a scan head by the names that people and scripts read.

#include <array>
#include <string_view>

#include "engrave/calibrate/cube_fit.h"

namespace intaglio::client {

struct HeadFigureName {
  calibrate::HeadUnknown unknown;
  std::string_view name;
  std::string_view unit;  ///< "": a ratio
};

inline constexpr std::array<HeadFigureName, calibrate::kHeadUnknowns> kHeadFigureNames = {
    {
        {calibrate::kXScale, "scale x", ""},
        {calibrate::kYScale, "scale y", ""},
        {calibrate::kSquareness, "squareness", "rad"},
        {calibrate::kRotation, "rotation", "rad"},
        {calibrate::kPupilX, "pupil x", "1/mm"},
        {calibrate::kPupilY, "pupil y", "1/mm"},
        {calibrate::kZRatio, "scale z", ""},
        {calibrate::kIndex, "index", ""},
        {calibrate::kTiltX, "tilt x", "rad"},
        {calibrate::kTiltY, "tilt y", "rad"},
        {calibrate::kLeanX, "lean x", "rad"},
        {calibrate::kLeanY, "lean y", "rad"},
        {calibrate::kOriginX, "corner x", "mm"},
        {calibrate::kOriginY, "corner y", "mm"},
        {calibrate::kTop, "face z", "mm"},
    }};

}  // namespace intaglio::client
