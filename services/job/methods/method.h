#pragma once

// A method of discretization as a job names it: a row of the table of methods
// (method_table.h). From the rows follows which method suits which model (model_kind.h);
// from the rules beside the fields of its message (services/platform/fields) follow the
// defaults of a job, the ranges of its numbers, the options of the command line and the
// table in docs/jobs.md. How it makes points is in a table of its own (point_maker.h),
// which only a program that makes points links.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "proto/job.pb.h"

namespace intaglio {

enum class ModelKind { kMesh, kDrawing, kText, kImage, kCloud, kCode };

/// A field that contradicts another field of the job.
struct MethodFault {
  std::string field;  ///< path from the method's message, "curve[2].from"
  std::string value;
  std::string what;  ///< follows the value in the sentence
};

struct Method {
  int number = 0;                     ///< of its field in Model.method
  std::vector<ModelKind> kinds = {};  ///< that it makes points of
  std::vector<ModelKind> default_of =
      {};                         ///< that it is the method of where none is named
  std::string_view meaning = {};  ///< a phrase, for docs/jobs.md
  /// The field with the distance of its layers, when an order by layers must not be
  /// thinner than that; else empty.
  std::string_view layer_field = {};
  /// The field with the number of its layers, where one layer has no distance; else
  /// empty.
  std::string_view layer_count_field = {};
  /// From layer to layer where the model gives an axis, length 1, glass frame; nothing:
  /// the normal of its sheet. `rotation`: of its placement. nullptr: none can be given.
  std::optional<Vec3> (*layer_axis)(const Model& model, const Mat3& rotation) = nullptr;
  /// Whether the model has it fill closed curves; nullptr: never.
  bool (*fills)(const Model& model) = nullptr;
  /// The distance of the lattice that its points lie on, mm
  /// (engrave/discretize/mesh/solid_lattice.h); nullptr: on none.
  double (*lattice_mm)(const Model& model) = nullptr;
  /// nullptr: nothing can contradict. `job` with its defaults filled in.
  std::vector<MethodFault> (*faults)(const JobSpec& job, const Model& model) = nullptr;

  const google::protobuf::FieldDescriptor& field() const;  ///< in Model
  const google::protobuf::Descriptor& message() const;     ///< its type
  const std::string& name() const;                         ///< "sections"
  bool Suits(ModelKind kind) const;
};

}  // namespace intaglio
