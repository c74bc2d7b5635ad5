#include "tests/services/job/methods/small_models.h"

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <string_view>

#include "tests/engrave/discretize/shapes.h"

namespace intaglio {
namespace {

FileBytes Bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::string ObjOf(const mesh::TriangleMesh& mesh) {
  std::string text;
  for (const Vec3& v : mesh.vertices) {
    text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    text += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
  }
  return text;
}

constexpr std::string_view kSvg =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm"
 viewBox="0 0 20 20"><path d="M1 1 H19 V19 Z"/><circle cx="9" cy="8" r="6"/></svg>)";

/// From dark on the left to bright on the right, 24 bits, 32 x 32.
std::string Ramp() {
  constexpr int kSide = 32, kStart = 54;
  std::string file = "BM";
  const auto put = [&file](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i)
      file.push_back(static_cast<char>((value >> (8 * i)) & 0xff));
  };
  put(kStart + kSide * kSide * 3, 4), put(0, 4), put(kStart, 4);
  put(40, 4), put(kSide, 4), put(kSide, 4), put(1, 2), put(24, 2);
  for (int i = 0; i < 6; ++i) put(0, 4);
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    for (int colour = 0; colour < 3; ++colour) put(8 * (i % kSide), 1);
  }
  return file;
}

}  // namespace

SmallModel SmallModelOf(ModelKind kind) {
  switch (kind) {
    case ModelKind::kMesh:
      return {"ball.obj", Bytes(ObjOf(discretize::Icosphere(5, 3, Vec3(0, 0, 0))))};
    case ModelKind::kImage:
      return {"ramp.bmp", Bytes(Ramp())};
    default:
      return {"badge.svg", Bytes(kSvg)};
  }
}

}  // namespace intaglio
