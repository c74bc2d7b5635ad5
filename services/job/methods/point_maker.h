#pragma once

// How a method of the table (method_table.h) makes points: turns the message of the job
// into the options of engrave/discretize. The algorithms know nothing of jobs. The makers
// lie by what they read: mesh_makers.cc, drawing_makers.cc, picture_makers.cc.

#include <map>
#include <memory>
#include <string_view>
#include <variant>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/discretize/drawing/curve_points.h"
#include "engrave/discretize/drawing/place_drawing.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/image/image_file.h"
#include "engrave/mesh/mesh.h"
#include "engrave/mesh/placement.h"
#include "services/job/methods/method.h"

namespace intaglio {

/// What every maker gets besides the model as its reader gives it.
struct MethodInput {
  const JobSpec& job;         ///< with its defaults filled in
  const Model& model;         ///< of that job, with this method
  mesh::Placement placement;  ///< of the model
  Vec3 block_size_mm;         ///< of the block that it is placed in
  /// The files that fields of the method name, by the field's name; linear light.
  std::map<std::string_view, image::GreyImage> images = {};
};

using MadePoints = Result<std::unique_ptr<discretize::PointSource>>;

/// The mesh: glass frame, mm; the maker may move from it.
using MeshMaker = MadePoints (*)(const MethodInput& input, mesh::TriangleMesh&& placed);
/// `inside`: what counts as the inside of closed curves, where it is filled.
using DrawingMaker = MadePoints (*)(const MethodInput& input,
                                    const discretize::PlacedDrawing& placed,
                                    discretize::CurveFill inside);
struct PictureMaker {
  image::Samples samples = image::Samples::kLinearLight;  ///< as which the file is read
  MadePoints (*make)(const MethodInput& input, const image::GreyImage& picture) = nullptr;
};

struct PointMaker {
  int method_number = 0;  ///< Method.number
  std::variant<MeshMaker, DrawingMaker, PictureMaker> make = {};
  /// The counts of which the job wants a warning; nullptr: all.
  discretize::MethodStatistics (*counts_to_warn_of)(
      const Model& model, discretize::MethodStatistics counts) = nullptr;
};

/// Precondition: a method of the table.
const PointMaker& MakerOf(const Method& method);

/// Parts of the table, in point_maker.cc put together.
std::vector<PointMaker> MeshMakers();
std::vector<PointMaker> DrawingMakers();
std::vector<PointMaker> PictureMakers();

}  // namespace intaglio
