#include "services/job/models/model_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include "engrave/mesh/base_face.h"
#include "engrave/mesh/plausible_size.h"
#include "engrave/mesh/up_convention.h"
#include "services/job/convert/model_kind.h"

namespace intaglio {
namespace {

using mesh::UpConvention;

// A person turns a model by hand to a degree or two.
constexpr double kUprightCosine = 0.999;

std::string NameOf(const Model& model) {
  return IsText(model)      ? model.text().text()
         : model.has_code() ? model.code().text()
                            : std::filesystem::path(model.file()).filename().string();
}

/// "--up -y (placement.up: UP_AXIS_MINUS_Y)".
std::string UpOption(mesh::UpAxis up) {
  const std::string_view name = mesh::NameOf(up);
  const char letter = static_cast<char>(std::toupper(name.back()));
  return fmt::format("--up {} (placement.up: UP_AXIS_{}{})", name,
                     name.front() == '-' ? "MINUS_" : "", letter);
}

void Add(const Model& model, std::string sentence, Warnings& warnings) {
  warnings.push_back(MakeWarning(WarningCode::kOrientation,
                                 fmt::format("{}: {}", NameOf(model), sentence)));
}

/// kZ where the file or a person has said which axis is up.
mesh::UpConvention OpenConventionOf(const Model& model,
                                    std::optional<mesh::UpAxis> declared) {
  if (declared || model.placement().up() != UP_AXIS_DECLARED) return UpConvention::kZ;
  return mesh::UpConventionOf(std::filesystem::path(model.file()).extension().string());
}

void AskForUp(const Model& model, UpConvention convention, Warnings& warnings) {
  Add(model,
      fmt::format(
          "its format names no axis that points up, and {} have y up; it is taken with z "
          "up. If it lies on its back in the picture, --accept up=y (placement.up: "
          "UP_AXIS_Y) stands it up; if not, --accept up=z ends this question",
          convention == UpConvention::kMostlyY ? "most of its files"
                                               : "many of its files"),
      warnings);
}

bool IsRotated(const MethodInput& input) {
  return !input.placement.rotation_rad.isZero();
}

bool IsMirrored(const MethodInput& input) {
  return input.placement.mirror_x || input.placement.mirror_y || input.placement.mirror_z;
}

/// A glTF that is rotated as it lies in its file does not come to stand by its rotation.
void AddForgottenUp(const MethodInput& input, std::optional<mesh::UpAxis> declared,
                    Warnings& warnings) {
  if (!declared || input.placement.up != mesh::UpAxis::kZ) return;
  const Vec3 up_in_glass =
      mesh::RotationOf(input.placement.rotation_rad) * mesh::DirectionOf(*declared);
  if (up_in_glass.z() > kUprightCosine) return;
  Add(input.model,
      fmt::format("the file has {} up, but with rotate_deg alone the model is rotated as "
                  "it lies in the file; add {} to stand it up first",
                  mesh::NameOf(*declared), UpOption(*declared)),
      warnings);
}

}  // namespace

Status CheckSize(const MethodInput& input, const Vec3& size_mm, Warnings& warnings) {
  mesh::SizeInBlock sized;
  sized.size_mm = size_mm;
  sized.block_size_mm = input.block_size_mm;
  sized.unit_mm = input.placement.unit_mm;
  sized.fitted = input.model.placement().fit_case() != Placement::FIT_NOT_SET;
  sized.clip = input.job.block().clip();
  sized.min_spacing_mm = input.job.discretization().min_spacing_mm();
  auto fault = mesh::FindSizeFault(sized, NameOf(input.model));
  if (!fault) return {};
  if (!fault->refused) {
    warnings.push_back(std::move(fault->warning));
    return {};
  }
  return Fail(ErrorCode::kOutsideBlock,
              mesh::FindSizeFault(sized, input.model.file())->warning.text,
              fmt::format("{:g}", size_mm.maxCoeff()));
}

void AddOrientationOfMesh(const MethodInput& input, std::optional<mesh::UpAxis> declared,
                          const mesh::TriangleMesh& placed, Warnings& warnings) {
  if (IsRotated(input)) return AddForgottenUp(input, declared, warnings);
  if (IsMirrored(input)) return;
  const auto upright = mesh::UpOfBaseFace(placed);
  const UpConvention convention = OpenConventionOf(input.model, declared);
  if (!upright) {
    if (convention != UpConvention::kZ && !mesh::RestsOnBase(placed))
      AskForUp(input.model, convention, warnings);
    return;
  }
  const Vec3 up_in_file =
      mesh::UprightFrom(input.placement.up).transpose() * mesh::DirectionOf(*upright);
  Add(input.model,
      fmt::format("its only flat face is {}; if this is its base, {} stands it up",
                  *upright == mesh::UpAxis::kMinusZ ? "at the top: it may be upside down"
                                                    : "in front: it may lie on its back",
                  UpOption(mesh::NearestUpAxis(up_in_file))),
      warnings);
  if (convention == UpConvention::kMostlyY &&
      mesh::NearestUpAxis(up_in_file) == mesh::UpAxis::kY) {
    warnings.back().weight = WarningWeight::kWarning;
  }
}

void AddOrientationOfSheet(const MethodInput& input, Warnings& warnings) {
  if (!IsRotated(input) || input.placement.up != mesh::UpAxis::kZ) return;
  const Vec3 normal = mesh::RotationOf(input.placement.rotation_rad) * Vec3(0, 0, 1);
  if (std::abs(normal.z()) < kUprightCosine) return;
  Add(input.model,
      fmt::format(
          "it lies flat in the block, because with rotate_deg alone it is rotated "
          "as it lies in its file; add {} to stand it up first",
          UpOption(mesh::UpAxis::kY)),
      warnings);
}

}  // namespace intaglio
