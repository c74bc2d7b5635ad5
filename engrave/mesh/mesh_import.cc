#include "engrave/mesh/mesh_import.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <exception>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

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

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 8> kExtensions = {"stl",  "obj", "ply", "3mf",
                                                         "gltf", "glb", "dae", "3ds"};

// More than any header of a PLY.
constexpr std::size_t kMaxPlyHeaderSize = 1 << 20;

/// A model file as errors speak of it, and the bounds it must keep.
struct Source {
  std::string name;
  std::string extension;
  ImportOptions options;

  tl::unexpected<Error> Refuse(ErrorCode code,
                               std::string_view problem_and_remedy) const {
    return Fail(code, fmt::format("{}: {}", name, problem_and_remedy), name);
  }
};

std::string LowerCaseExtension(std::string_view text) {
  if (!text.empty() && text.front() == '.') text.remove_prefix(1);
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  return lower;
}

Status CheckExtension(const Source& source) {
  if (std::find(kExtensions.begin(), kExtensions.end(), source.extension) !=
      kExtensions.end()) {
    return {};
  }
  return source.Refuse(
      ErrorCode::kUnsupported,
      fmt::format("models of the kind '{}' are not read; export it as one of {}",
                  source.extension, fmt::join(kExtensions, ", ")));
}

Status CheckSize(const Source& source, std::uint64_t byte_count) {
  if (byte_count == 0) {
    return source.Refuse(ErrorCode::kUnreadable, "the file is empty; export it again");
  }
  if (byte_count > source.options.max_file_bytes) {
    return source.Refuse(
        ErrorCode::kTooLarge,
        fmt::format("the file has {} bytes, more than the {} allowed; reduce the mesh or "
                    "raise the limit",
                    byte_count, source.options.max_file_bytes));
  }
  return {};
}

Status CheckFile(const Source& source, const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) {
    return source.Refuse(ErrorCode::kNotFound,
                         "there is no such file; check its name and folder");
  }
  if (!error && status.type() != fs::file_type::regular) {
    return source.Refuse(ErrorCode::kIo, "this is not a file; name a model file");
  }
  const std::uint64_t byte_count = error ? 0 : fs::file_size(file, error);
  if (error || !std::ifstream(file, std::ios::binary)) {
    return source.Refuse(ErrorCode::kIo,
                         "the file cannot be opened; check that you may read it");
  }
  return CheckSize(source, byte_count);
}

/// The library reads on for ever where a PLY header does not end, as in a file cut short.
/// `beginning` is the file or its first kMaxPlyHeaderSize bytes.
Status CheckPlyHeaderEnds(const Source& source, std::string_view beginning) {
  constexpr std::string_view kEnd = "\nend_header";
  const std::size_t at = beginning.find(kEnd);
  if (at != std::string_view::npos) {
    const std::string_view rest = beginning.substr(at + kEnd.size());
    if (!rest.empty() && (rest.front() == '\n' || rest.front() == '\r')) return {};
  }
  return source.Refuse(ErrorCode::kUnreadable,
                       "it cannot be read as ply (its header does not end with a line "
                       "end_header); check that it is complete, or export it again");
}

/// The library reads a DAE's index lists for ever where something else than a number is
/// in them.
Status CheckIndexLists(const Source& source, std::string_view text) {
  constexpr std::string_view kBegin = "<p>";
  for (std::size_t at = text.find(kBegin); at != std::string_view::npos;
       at = text.find(kBegin, at)) {
    at += kBegin.size();
    const std::size_t end = text.find('<', at);
    if (text.substr(at, end - at).find_first_not_of("0123456789- \t\r\n") !=
        std::string_view::npos) {
      return source.Refuse(ErrorCode::kUnreadable,
                           "it cannot be read as dae (a list of indices holds something "
                           "else than numbers); the file is damaged, export it again");
    }
  }
  return {};
}

/// What is checked of a file's content before the library sees it.
Status CheckContent(const Source& source, std::string_view text) {
  if (source.extension == "ply") {
    return CheckPlyHeaderEnds(source, text.substr(0, kMaxPlyHeaderSize));
  }
  if (source.extension == "dae") return CheckIndexLists(source, text);
  return {};
}

/// As much of the file as CheckContent() looks at.
std::string ContentToCheck(const Source& source, const fs::path& file) {
  std::size_t size = 0;
  if (source.extension == "ply") size = kMaxPlyHeaderSize;
  if (source.extension == "dae") {
    std::error_code unreadable;
    size = fs::file_size(file, unreadable);
    if (unreadable) size = 0;
  }
  std::string content(size, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(content.data(), static_cast<std::streamsize>(content.size()));
  content.resize(static_cast<std::size_t>(in.gcount()));
  return content;
}

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

/// Assimp lays a 3DS down, z-up to y-up: (x, y, z) -> (x, z, -y). This stands it up
/// again.
NodeTransform ModelFromScene(const Source& source) {
  NodeTransform transform;
  if (source.extension == "3ds") transform.linear << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return transform;
}

/// Calls `visit` for each mesh of each node, depth first and in file order, with its
/// transform. A stack of our own: a file may nest nodes as deep as it likes. Stops at
/// the first error.
Status ForEachInstance(
    const aiScene& scene, const NodeTransform& model_from_scene,
    const std::function<Status(const aiMesh&, const NodeTransform&)>& visit) {
  if (scene.mRootNode == nullptr) return {};
  std::vector<std::pair<const aiNode*, NodeTransform>> pending;
  pending.emplace_back(scene.mRootNode,
                       model_from_scene.Child(scene.mRootNode->mTransformation));
  while (!pending.empty()) {
    const auto [node, model_from_node] = pending.back();
    pending.pop_back();
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
      if (node->mMeshes[i] >= scene.mNumMeshes) continue;
      Status status = visit(*scene.mMeshes[node->mMeshes[i]], model_from_node);
      if (!status) return status;
    }
    for (unsigned i = node->mNumChildren; i-- > 0;) {
      const aiNode* child = node->mChildren[i];
      pending.emplace_back(child, model_from_node.Child(child->mTransformation));
    }
  }
  return {};
}

/// Refuses indices that point nowhere, before the library's triangulation trusts them,
/// and more triangles than allowed.
Status CheckFaces(const Source& source, const aiScene& scene) {
  std::vector<std::uint64_t> triangle_counts(scene.mNumMeshes, 0);
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      for (unsigned c = 0; c < face.mNumIndices; ++c) {
        if (face.mIndices[c] >= part.mNumVertices) {
          return source.Refuse(
              ErrorCode::kUnreadable,
              fmt::format("face {} names vertex {} of {}; the file is damaged, export it "
                          "again",
                          f, face.mIndices[c], part.mNumVertices));
        }
      }
      if (face.mNumIndices >= 3) triangle_counts[m] += face.mNumIndices - 2;
    }
  }
  std::uint64_t total = 0;
  return ForEachInstance(
      scene, {}, [&](const aiMesh& part, const NodeTransform&) -> Status {
        const auto index = static_cast<std::size_t>(
            std::find(scene.mMeshes, scene.mMeshes + scene.mNumMeshes, &part) -
            scene.mMeshes);
        total += triangle_counts[index];
        if (total <= source.options.max_triangles) return {};
        return source.Refuse(
            ErrorCode::kTooLarge,
            fmt::format(
                "the model has more than the {} triangles allowed; reduce the mesh or "
                "raise the limit",
                source.options.max_triangles));
      });
}

/// Adds the triangles of one instance to the mesh.
Status AddInstance(const Source& source, const aiMesh& part,
                   const NodeTransform& model_from_node, VertexWelder& welder,
                   std::vector<Triangle>& triangles) {
  constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> welded(part.mNumVertices, kUnset);
  const bool mirrors = model_from_node.linear.determinant() < 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;
    Triangle corners;
    for (unsigned c = 0; c < 3; ++c) {
      const unsigned index = face.mIndices[c];
      if (welded[index] == kUnset) {
        const Vec3 p = model_from_node.Apply(part.mVertices[index]);
        if (!p.allFinite()) {
          return source.Refuse(
              ErrorCode::kInvalidValue,
              fmt::format("a corner of triangle {} lies at ({}, {}, {}), which is not a "
                          "place; export the model again",
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

Result<TriangleMesh> MeshFromScene(const Source& source, Assimp::Importer& importer) {
  const aiScene* scene = importer.GetScene();
  if (scene == nullptr) {
    return source.Refuse(
        ErrorCode::kUnreadable,
        fmt::format("it cannot be read as {} ({}); check that it is complete and of that "
                    "format, or export it again",
                    source.extension, importer.GetErrorString()));
  }
  if (Status status = CheckFaces(source, *scene); !status) {
    return tl::unexpected(status.error());
  }
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) {
    return source.Refuse(ErrorCode::kUnreadable,
                         fmt::format("its polygons cannot be cut into triangles ({}); "
                                     "export it as triangles",
                                     importer.GetErrorString()));
  }
  VertexWelder welder;
  TriangleMesh mesh;
  const Status status = ForEachInstance(
      *scene, ModelFromScene(source),
      [&](const aiMesh& part, const NodeTransform& model_from_node) {
        return AddInstance(source, part, model_from_node, welder, mesh.triangles);
      });
  if (!status) return tl::unexpected(status.error());
  if (mesh.triangles.empty()) {
    return source.Refuse(ErrorCode::kMissing,
                         "it holds no triangles; export the model as a surface mesh, not "
                         "as points or lines");
  }
  mesh.vertices = welder.TakePoints();
  return mesh;
}

/// Assimp before 5.4 frees the pictures of a 3MF package while the scene still points to
/// them, and the scene's destructor frees them again (its issues 5307 and 5328). They
/// are of no use here, so the scene is made to forget them.
void ForgetFreedPictures(const Source& source, Assimp::Importer& importer) {
  const bool fixed =
      std::pair(aiGetVersionMajor(), aiGetVersionMinor()) >= std::pair(5u, 4u);
  if (fixed || source.extension != "3mf" || importer.GetScene() == nullptr) return;
  auto* scene = const_cast<aiScene*>(importer.GetScene());
  delete[] scene->mTextures;  // the array of pointers only
  scene->mTextures = nullptr;
  scene->mNumTextures = 0;
}

/// Runs `read`, which lets the importer read, and turns whatever is thrown into an error.
Result<TriangleMesh> Import(const Source& source,
                            const std::function<void(Assimp::Importer&)>& read) {
  try {
    Assimp::Importer importer;
    importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    read(importer);
    ForgetFreedPictures(source, importer);
    return MeshFromScene(source, importer);
  } catch (const std::bad_alloc&) {
    return source.Refuse(ErrorCode::kTooLarge,
                         "there is not enough memory to read it; reduce the mesh");
  } catch (const std::exception& thrown) {
    return source.Refuse(
        ErrorCode::kUnreadable,
        fmt::format("it cannot be read ({}); export it again", thrown.what()));
  }
}

}  // namespace

Result<TriangleMesh> ImportMesh(const fs::path& file, const ImportOptions& options) {
  const Source source{file.string(), LowerCaseExtension(file.extension().string()),
                      options};
  if (Status status = CheckFile(source, file); !status) {
    return tl::unexpected(status.error());
  }
  if (Status status = CheckExtension(source); !status) {
    return tl::unexpected(status.error());
  }
  if (Status status = CheckContent(source, ContentToCheck(source, file)); !status) {
    return tl::unexpected(status.error());
  }
  return Import(source,
                [&](Assimp::Importer& importer) { importer.ReadFile(file.string(), 0); });
}

Result<TriangleMesh> ImportMeshFromMemory(std::span<const std::byte> bytes,
                                          std::string_view extension,
                                          const ImportOptions& options,
                                          std::string_view name) {
  const Source source{std::string(name), LowerCaseExtension(extension), options};
  if (Status status = CheckExtension(source); !status) {
    return tl::unexpected(status.error());
  }
  if (Status status = CheckSize(source, bytes.size()); !status) {
    return tl::unexpected(status.error());
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (Status status = CheckContent(source, text); !status) {
    return tl::unexpected(status.error());
  }
  return Import(source, [&](Assimp::Importer& importer) {
    importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, source.extension.c_str());
  });
}

}  // namespace intaglio::mesh
