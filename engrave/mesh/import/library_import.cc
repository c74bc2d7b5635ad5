#include "engrave/mesh/import/library_import.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <exception>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/mesh/weld_vertices.h"

// Debian builds Assimp with its assertions on, and a failed one, which a damaged file can
// cause (a wrong checksum in a 3MF), aborts the process. The library calls this function
// of its own through the dynamic linker, which finds ours first: thrown, the violation
// ends as the reader's error.
namespace Assimp {
__attribute__((visibility("default"))) void aiAssertViolation(const char* expression,
                                                              const char* file, int line);
void aiAssertViolation(const char* expression, const char* file, int line) {
  throw std::runtime_error(fmt::format("{} at {}:{}", expression, file, line));
}
}  // namespace Assimp

namespace intaglio::mesh {
namespace {

/// model_from_node: the linear part and the offset, in double from the file's floats.
struct NodeTransform {
  Mat3 linear = Mat3::Identity();
  Vec3 offset = Vec3::Zero();

  Vec3 Apply(const aiVector3D& v) const { return linear * Vec3(v.x, v.y, v.z) + offset; }
  NodeTransform Child(const aiMatrix4x4& m) const {
    Mat3 child;
    child << m.a1, m.a2, m.a3, m.b1, m.b2, m.b3, m.c1, m.c2, m.c3;
    return {linear * child, linear * Vec3(m.a4, m.b4, m.c4) + offset};
  }
};

/// Assimp lays a 3DS down, z-up to y-up: (x, y, z) -> (x, z, -y). This turns it upright
/// again.
NodeTransform ModelFromScene(const ImportSource& source) {
  NodeTransform transform;
  if (source.extension == "3ds") transform.linear << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  transform.linear *= source.unit_mm;
  return transform;
}

struct Node {
  const aiNode* node = nullptr;
  NodeTransform model_from_node;
  bool is_wanted = true;  ///< it belongs to one of the objects that are asked for
};

bool IsNamed(const aiNode& node, const std::vector<std::string>& names) {
  return std::ranges::find(names, node.mName.C_Str()) != names.end();
}

/// Calls `visit` for each node, depth first and in file order. An explicit stack, because
/// a file may nest nodes to any depth. Stops at the first error.
Status ForEachNode(const aiScene& scene, const ImportSource& source,
                   const NodeTransform& model_from_scene,
                   const std::function<Status(const Node&)>& visit) {
  if (scene.mRootNode == nullptr) return {};
  const std::vector<std::string>& objects = source.options.objects;
  const auto below = [&](const aiNode& node, const NodeTransform& parent, bool wanted) {
    return Node{&node, parent.Child(node.mTransformation),
                wanted || IsNamed(node, objects)};
  };
  std::vector<Node> pending{below(*scene.mRootNode, model_from_scene, objects.empty())};
  while (!pending.empty()) {
    const Node one = pending.back();
    pending.pop_back();
    INTAGLIO_TRY(visit(one));
    for (unsigned i = one.node->mNumChildren; i-- > 0;) {
      pending.push_back(
          below(*one.node->mChildren[i], one.model_from_node, one.is_wanted));
    }
  }
  return {};
}

/// Calls `visit` for each mesh of each node that is wanted.
Status ForEachInstance(
    const aiScene& scene, const ImportSource& source,
    const NodeTransform& model_from_scene,
    const std::function<Status(const aiMesh&, const NodeTransform&)>& visit) {
  return ForEachNode(scene, source, model_from_scene, [&](const Node& one) -> Status {
    for (unsigned i = 0; one.is_wanted && i < one.node->mNumMeshes; ++i) {
      if (one.node->mMeshes[i] >= scene.mNumMeshes) continue;
      INTAGLIO_TRY(visit(*scene.mMeshes[one.node->mMeshes[i]], one.model_from_node));
    }
    return {};
  });
}

/// Whether it or a node below it has a mesh.
bool HoldsMesh(const aiNode& node) {
  std::vector<const aiNode*> pending{&node};
  while (!pending.empty()) {
    const aiNode& one = *pending.back();
    pending.pop_back();
    if (one.mNumMeshes > 0) return true;
    pending.insert(pending.end(), one.mChildren, one.mChildren + one.mNumChildren);
  }
  return false;
}

/// Refuses names that no node with a mesh has, with those that the file has.
Status CheckObjects(const ImportSource& source, const aiScene& scene) {
  if (source.options.objects.empty()) return {};
  std::vector<std::string> names;
  INTAGLIO_TRY(ForEachNode(scene, source, {}, [&](const Node& one) -> Status {
    // Above all objects, and with a name of the library's.
    if (one.node == scene.mRootNode && one.node->mNumMeshes == 0) return {};
    const std::string name = one.node->mName.C_Str();
    const bool is_new = std::ranges::find(names, name) == names.end();
    if (!name.empty() && is_new && HoldsMesh(*one.node)) names.push_back(name);
    return {};
  }));
  for (const std::string& asked : source.options.objects) {
    if (std::ranges::find(names, asked) == names.end())
      return source.RefuseObject(asked, names);
  }
  return {};
}

/// Refuses indices out of range, before the library's triangulation uses them, and more
/// triangles than allowed.
Status CheckFaces(const ImportSource& source, const aiScene& scene) {
  std::vector<std::uint64_t> triangle_counts(scene.mNumMeshes, 0);
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      for (unsigned c = 0; c < face.mNumIndices; ++c) {
        if (face.mIndices[c] >= part.mNumVertices) {
          return source.Refuse(ErrorCode::kUnreadable,
                               fmt::format("face {} refers to vertex {} of {}; the file "
                                           "is damaged, export it again",
                                           f, face.mIndices[c], part.mNumVertices));
        }
      }
      if (face.mNumIndices >= 3) triangle_counts[m] += face.mNumIndices - 2;
    }
  }
  std::uint64_t total = 0;
  return ForEachInstance(
      scene, source, {}, [&](const aiMesh& part, const NodeTransform&) -> Status {
        const auto index = static_cast<std::size_t>(
            std::find(scene.mMeshes, scene.mMeshes + scene.mNumMeshes, &part) -
            scene.mMeshes);
        total += triangle_counts[index];
        if (total <= source.options.max_triangles) return {};
        return source.RefuseTriangleCount();
      });
}

/// Adds the triangles of one instance to the mesh.
Status AddInstance(const ImportSource& source, const aiMesh& part,
                   const NodeTransform& model_from_node, VertexWelder& welder,
                   std::vector<Triangle>& triangles) {
  constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> welded(part.mNumVertices, kUnset);
  const bool mirrors = model_from_node.linear.determinant() < 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;  // AddFindings counts them
    Triangle corners;
    for (unsigned c = 0; c < 3; ++c) {
      const unsigned index = face.mIndices[c];
      if (welded[index] == kUnset) {
        const Vec3 p = model_from_node.Apply(part.mVertices[index]);
        if (!p.allFinite()) {
          return source.Refuse(ErrorCode::kInvalidValue,
                               fmt::format("a corner of triangle {} is at ({}, {}, {}), "
                                           "which is not finite; export the model again",
                                           triangles.size(), p.x(), p.y(), p.z()));
        }
        welded[index] = welder.Add(p);
      }
      corners[c] = welded[index];
    }
    if (mirrors) std::swap(corners[1], corners[2]);
    triangles.push_back(corners);
  }
  return {};
}

/// What an instance has and the mesh that is made of it has not.
void AddFindings(const ImportSource& source, const aiMesh& part, FileFindings& findings) {
  const auto add = [&](std::uint64_t count, const char* what, const char* remedy,
                       Effect effect) {
    if (count == 0) return;
    const std::string name = part.mName.C_Str();
    const std::string where = name.empty() ? "" : "mesh " + name;
    findings.Add({.what = what,
                  .where = where,
                  .remedy = remedy,
                  .count = count,
                  .effect = effect});
  };
  const auto lines = std::count_if(
      part.mFaces, part.mFaces + part.mNumFaces,
      [](const aiFace& face) { return face.mNumIndices == 1 || face.mNumIndices == 2; });
  add(static_cast<std::uint64_t>(lines), "point or line", "only faces are read",
      Effect::kLost);
  add(part.HasBones() ? 1 : 0, "skin",
      "apply the armature, so that the mesh has its pose, and export it again",
      Effect::kChanged);
  // Those of glTF are found in its text, because the library leaves out those of nodes.
  const bool is_gltf = source.extension == "gltf" || source.extension == "glb";
  add(is_gltf ? 0 : part.mNumAnimMeshes, "morph target",
      "apply the shape keys and export it again", Effect::kChanged);
}

Result<ImportedMesh> MeshFromScene(const ImportSource& source,
                                   Assimp::Importer& importer) {
  const aiScene* scene = importer.GetScene();
  if (scene == nullptr) {
    return source.RefuseAsUnreadable(importer.GetErrorString());
  }
  INTAGLIO_TRY(CheckFaces(source, *scene));
  INTAGLIO_TRY(CheckObjects(source, *scene));
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) {
    return source.Refuse(
        ErrorCode::kUnreadable,
        fmt::format("its polygons cannot be triangulated ({}); export it as triangles",
                    importer.GetErrorString()));
  }
  VertexWelder welder;
  ImportedMesh mesh;
  INTAGLIO_TRY(ForEachInstance(
      *scene, source, ModelFromScene(source),
      [&](const aiMesh& part, const NodeTransform& model_from_node) {
        AddFindings(source, part, mesh.findings);
        return AddInstance(source, part, model_from_node, welder, mesh.triangles);
      }));
  if (mesh.triangles.empty()) {
    return source.RefuseEmptyModel();
  }
  mesh.vertices = welder.TakePoints();
  return mesh;
}

/// No file but the one in memory: the library would take another of that name from the
/// working directory.
class NoOtherFiles final : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

/// Leaves the importer only the readers of the source's extension. Otherwise a file
/// refused by those is offered to all others, which search it for their signatures, and
/// our checks do not cover these readers: a .gltf that is a cut PLY was read for ever.
void KeepReadersOf(const ImportSource& source, Assimp::Importer& importer) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* reader = importer.GetImporter(i);
    std::set<std::string> extensions;
    reader->GetExtensionList(extensions);
    if (extensions.count(source.extension) != 0) continue;
    importer.UnregisterLoader(reader);
    delete reader;  // the caller of UnregisterLoader owns it
  }
}

}  // namespace

Result<ImportedMesh> ImportByLibrary(const ImportSource& source,
                                     const std::function<void(Assimp::Importer&)>& read) {
  try {
    Assimp::Importer importer;
    importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    importer.SetIOHandler(new NoOtherFiles);  // which it then owns
    KeepReadersOf(source, importer);
    read(importer);
    return MeshFromScene(source, importer);
  } catch (const std::bad_alloc&) {
    return source.Refuse(ErrorCode::kTooLarge,
                         "not enough memory to read it; reduce the mesh");
  } catch (const std::exception& thrown) {
    return source.Refuse(
        ErrorCode::kUnreadable,
        fmt::format("it cannot be read ({}); export it again", thrown.what()));
  }
}

}  // namespace intaglio::mesh
