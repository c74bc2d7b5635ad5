#include "engrave/mesh/up_axis.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "engrave/core/check.h"
#include "engrave/mesh/files/collada_check.h"
#include "engrave/mesh/files/declared_axis.h"

namespace intaglio::mesh {
namespace {

constexpr UpAxis kAll[] = {UpAxis::kX,      UpAxis::kY,      UpAxis::kZ,
                           UpAxis::kMinusX, UpAxis::kMinusY, UpAxis::kMinusZ};

TEST(UpAxis, BecomesZByAnExactTurn) {
  for (const UpAxis up : kAll) {
    const Mat3 turn = UprightFrom(up);
    EXPECT_EQ(turn * DirectionOf(up), Vec3(0, 0, 1)) << NameOf(up);
    EXPECT_EQ(turn * turn.transpose(), Mat3(Mat3::Identity())) << NameOf(up);
    EXPECT_EQ(turn.determinant(), 1) << NameOf(up) << ": a mirror, not a turn";
    EXPECT_EQ(NearestUpAxis(DirectionOf(up)), up);
  }
  EXPECT_EQ(UprightFrom(UpAxis::kZ), Mat3(Mat3::Identity()));
}

// glTF 2.0, 3.4: y is up, and the front of an asset faces +z. The viewer is at -y.
TEST(UpAxis, TheFrontOfAGltfFacesTheViewer) {
  EXPECT_EQ(UprightFrom(UpAxis::kY) * Vec3(0, 0, 1), Vec3(0, -1, 0));
  EXPECT_EQ(UprightFrom(UpAxis::kY) * Vec3(1, 0, 0), Vec3(1, 0, 0));
}

// COLLADA 1.4.1, up_axis: X_UP has right = -y and in = +z, that is away from the viewer's
// back: what is out of the screen, +z, faces the viewer.
TEST(UpAxis, XUpIsTurnedAsColladaDefinesIt) {
  EXPECT_EQ(UprightFrom(UpAxis::kX) * Vec3(0, -1, 0), Vec3(1, 0, 0));
  EXPECT_EQ(UprightFrom(UpAxis::kX) * Vec3(0, 0, 1), Vec3(0, -1, 0));
}

TEST(UpAxis, FollowsFromTheFormatOrTheFile) {
  EXPECT_EQ(UpAxisOfFile(".GLB", ""), UpAxis::kY);
  EXPECT_EQ(UpAxisOfFile("gltf", ""), UpAxis::kY);
  for (const char* extension : {"stl", "obj", "ply", "3mf", "3ds", ""}) {
    EXPECT_EQ(UpAxisOfFile(extension, "<up_axis>X_UP</up_axis>"), std::nullopt);
  }
  EXPECT_EQ(UpAxisOfFile(".dae", "<asset><up_axis>Z_UP</up_axis></asset>"), UpAxis::kZ);
}

TEST(UpAxis, OfColladaIsYUnlessItIsNamed) {
  EXPECT_EQ(UpAxisInCollada("<up_axis>Z_UP</up_axis>"), UpAxis::kZ);
  EXPECT_EQ(UpAxisInCollada("<up_axis>\n  X_UP\n</up_axis>"), UpAxis::kX);
  EXPECT_EQ(UpAxisInCollada("<up_axis>Y_UP</up_axis>"), UpAxis::kY);
  for (const char* none : {"", "<asset/>", "<up_axis", "<up_axis>", "<up_axis>  ",
                           "<up_axis>W_UP</up_axis>"}) {
    EXPECT_EQ(UpAxisInCollada(none), UpAxis::kY) << none;
  }
}

TEST(UpAxis, TheNearestAxisOfADirection) {
  EXPECT_EQ(NearestUpAxis({0.1, -0.9, 0.3}), UpAxis::kMinusY);
  EXPECT_THROW((void)NearestUpAxis(Vec3::Zero()), PreconditionError);
}

}  // namespace
}  // namespace intaglio::mesh
