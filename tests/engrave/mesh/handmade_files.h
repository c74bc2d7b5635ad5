#pragma once

// Model files made by hand, in each format, without the library under test.

#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

template <typename T>
void Append(std::string& bytes, T value) {
  static_assert(std::is_trivially_copyable_v<T>);
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

inline std::string AsciiStl(const TriangleMesh& mesh) {
  std::string text = "solid box\n";
  for (const Triangle& t : mesh.triangles) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const auto corner : t) {
      const Vec3& v = mesh.vertices[corner];
      text += fmt::format("  vertex {} {} {}\n", v.x(), v.y(), v.z());
    }
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid box\n";
}

inline std::string BinaryStl(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  Append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) Append(bytes, 0.0f);  // normal
    for (const auto corner : t) {
      for (int axis = 0; axis < 3; ++axis) {
        Append(bytes, static_cast<float>(mesh.vertices[corner][axis]));
      }
    }
    Append(bytes, std::uint16_t{0});
  }
  return bytes;
}

inline std::string Obj(const TriangleMesh& mesh) {
  std::string text = "o box\n";
  for (const Vec3& v : mesh.vertices)
    text += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
  // Another normal at each corner: the library splits the vertices by it.
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += fmt::format("vn 0 {} 1\nusemtl m{}\n", t, t % 3);
    const Triangle& c = mesh.triangles[t];
    text += fmt::format("f {}//{n} {}//{n} {}//{n}\n", c[0] + 1, c[1] + 1, c[2] + 1,
                        fmt::arg("n", t + 1));
  }
  return text;
}

inline std::string Ply(const TriangleMesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nelement face {}\nproperty list uchar int vertex_indices\n"
      "end_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& v : mesh.vertices) text += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
  for (const Triangle& t : mesh.triangles)
    text += fmt::format("3 {}\n", fmt::join(t, " "));
  return text;
}

/// As programs write it that keep colours: of the vertices and of the faces.
inline std::string BinaryPly(const TriangleMesh& mesh) {
  const std::string colours =
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property uchar alpha\n";
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment made\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n{}element face {}\n"
      "property list uchar int vertex_indices\n{}end_header\n",
      mesh.vertices.size(), colours, mesh.triangles.size(), colours);
  const std::string colour("\x10\x80\n\xff", 4);
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) Append(bytes, static_cast<float>(v[axis]));
    bytes += colour;
  }
  for (const Triangle& t : mesh.triangles) {
    Append(bytes, std::uint8_t{3});
    for (const auto corner : t) Append(bytes, static_cast<std::int32_t>(corner));
    bytes += colour;
  }
  return bytes;
}

inline std::string Dae(const TriangleMesh& mesh, const std::string& asset,
                       const std::string& matrix) {
  std::string positions;
  for (const Vec3& v : mesh.vertices) {
    positions += fmt::format("{} {} {} ", v[0], v[1], v[2]);
  }
  std::string indices;
  for (const Triangle& t : mesh.triangles)
    indices += fmt::format("{} ", fmt::join(t, " "));
  return fmt::format(
      R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{}</asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{}">{}</float_array><technique_common>
<accessor source="#a" count="{}" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{}"><input semantic="VERTEX" source="#v" offset="0"/><p>{}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>{}</matrix>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)",
      asset, 3 * mesh.vertices.size(), positions, mesh.vertices.size(),
      mesh.triangles.size(), indices, matrix);
}

/// A glTF with its buffer inside, as base64, and a node transform (column by column).
inline std::string Gltf(const TriangleMesh& mesh, const std::string& matrix) {
  std::string buffer;
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) Append(buffer, static_cast<float>(v[axis]));
  }
  const std::size_t index_offset = buffer.size();
  for (const Triangle& t : mesh.triangles) {
    for (const auto corner : t) Append(buffer, static_cast<std::uint16_t>(corner));
  }
  const Vec3 top = mesh.Bounds().max_mm;
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i < buffer.size(); i += 3) {  // the size is a multiple of 3
    const auto byte = [&](std::size_t k) {
      return unsigned(std::uint8_t(buffer[i + k]));
    };
    const unsigned bits = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += kDigits[bits >> shift & 63];
  }
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"mesh":0,"matrix":[{}]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{}}},
{{"buffer":0,"byteOffset":{},"byteLength":{}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",
"min":[0,0,0],"max":[{},{},{}]}},
{{"bufferView":1,"componentType":5123,"count":{},"type":"SCALAR"}}]}})",
      matrix, buffer.size(), base64, index_offset, index_offset,
      buffer.size() - index_offset, mesh.vertices.size(), top.x(), top.y(), top.z(),
      3 * mesh.triangles.size());
}

/// A binary glTF: a node with a matrix (column by column), and the mesh in a node below.
inline std::string Glb(const TriangleMesh& mesh, const std::string& matrix) {
  std::string buffer;
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) Append(buffer, static_cast<float>(v[axis]));
  }
  const std::size_t index_offset = buffer.size();
  for (const Triangle& t : mesh.triangles) {
    for (const auto corner : t) Append(buffer, static_cast<std::uint32_t>(corner));
  }
  const Box3 box = mesh.Bounds();
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"children":[1],"matrix":[{}]}},{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"buffers":[{{"byteLength":{}}}],"bufferViews":[
{{"buffer":0,"byteOffset":0,"byteLength":{}}},
{{"buffer":0,"byteOffset":{},"byteLength":{}}}],"accessors":[
{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",
"min":[{}],"max":[{}]}},
{{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}]}})",
      matrix, buffer.size(), index_offset, index_offset, buffer.size() - index_offset,
      mesh.vertices.size(), fmt::join(box.min_mm, ","), fmt::join(box.max_mm, ","),
      3 * mesh.triangles.size());
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string bytes = "glTF";
  Append(bytes, std::uint32_t{2});
  Append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + buffer.size()));
  Append(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  Append(bytes, static_cast<std::uint32_t>(buffer.size()));
  return bytes + std::string("BIN\0", 4) + buffer;
}

/// The content as method 8 of a zip archive has it.
inline std::string Deflated(const std::string& content) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, content.size()), '\0');
  stream.next_in =
      reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));  // is only read
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// A zip archive, of stored (uncompressed) files unless they are to be deflated.
inline std::string Zip(const std::vector<std::pair<std::string, std::string>>& files,
                       bool deflated = false) {
  std::string zip;
  std::string directory;
  for (const auto& [name, content] : files) {
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(content.data()),
              static_cast<uInt>(content.size())));
    const std::string packed = deflated ? Deflated(content) : content;
    std::string common;  // the fields that both headers share
    for (const int field : {20, 0, deflated ? 8 : 0, 0, 33}) {
      Append(common, static_cast<std::uint16_t>(field));
    }
    Append(common, crc);
    Append(common, static_cast<std::uint32_t>(packed.size()));
    Append(common, static_cast<std::uint32_t>(content.size()));
    Append(common, static_cast<std::uint16_t>(name.size()));
    Append(common, std::uint16_t{0});
    directory += "PK\1\2";
    Append(directory, std::uint16_t{20});
    directory += common;
    directory.append(10, '\0');
    Append(directory, static_cast<std::uint32_t>(zip.size()));
    directory += name;
    zip += "PK\3\4";
    zip += common;
    zip += name;
    zip += packed;
  }
  const auto directory_offset = static_cast<std::uint32_t>(zip.size());
  zip += directory + "PK\5\6" + std::string(4, '\0');
  for (int i = 0; i < 2; ++i) Append(zip, static_cast<std::uint16_t>(files.size()));
  Append(zip, static_cast<std::uint32_t>(directory.size()));
  Append(zip, directory_offset);
  Append(zip, std::uint16_t{0});
  return zip;
}

/// An object of a 3MF.
inline std::string ThreeMfObject(int id, const TriangleMesh& mesh) {
  std::string vertices;
  for (const Vec3& v : mesh.vertices) {
    vertices += fmt::format(R"(<vertex x="{}" y="{}" z="{}"/>)", v[0], v[1], v[2]);
  }
  std::string triangles;
  for (const Triangle& t : mesh.triangles) {
    triangles += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"/>)", t[0], t[1], t[2]);
  }
  return fmt::format(
      R"(<object id="{}" type="model"><mesh><vertices>{}</vertices><triangles>{}</triangles></mesh></object>)",
      id, vertices, triangles);
}

/// A 3MF of these objects and items, with a picture (which the library mishandles).
inline std::string ThreeMfOf(const std::string& unit, const std::string& objects,
                             const std::string& items, bool deflated = false) {
  const std::string packages = "http://schemas.openxmlformats.org/package/2006/";
  const std::string model = fmt::format(
      R"(<?xml version="1.0"?><model unit="{}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>{}</resources><build>{}</build></model>)",
      unit, objects, items);
  return Zip(
      {{"[Content_Types].xml",
        fmt::format(
            R"(<?xml version="1.0"?><Types xmlns="{}content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>)",
            packages)},
       {"_rels/.rels",
        fmt::format(
            R"(<?xml version="1.0"?><Relationships xmlns="{}relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)",
            packages)},
       {"3D/3dmodel.model", model},
       {"Metadata/thumbnail.png", "a picture of eleven thousand bytes"}},
      deflated);
}

/// A 3MF of one object, placed twice.
inline std::string ThreeMf(const TriangleMesh& mesh, const std::string& unit,
                           const std::string& second_transform) {
  return ThreeMfOf(
      unit, ThreeMfObject(1, mesh),
      fmt::format(R"(<item objectid="1"/><item objectid="1" transform="{}"/>)",
                  second_transform));
}

/// A 3DS of one object. The file's faces carry 16-bit indices.
inline std::string ThreeDs(const TriangleMesh& mesh) {
  const auto chunk = [](std::uint16_t id, const std::string& content) {
    std::string bytes;
    Append(bytes, id);
    Append(bytes, static_cast<std::uint32_t>(content.size() + 6));
    return bytes + content;
  };
  std::string vertices;
  Append(vertices, static_cast<std::uint16_t>(mesh.vertices.size()));
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) Append(vertices, static_cast<float>(v[axis]));
  }
  std::string faces;
  Append(faces, static_cast<std::uint16_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    for (const auto corner : t) Append(faces, static_cast<std::uint16_t>(corner));
    Append(faces, std::uint16_t{0});
  }
  const std::string triangle_mesh =
      chunk(0x4100, chunk(0x4110, vertices) + chunk(0x4120, faces));
  const std::string object = chunk(0x4000, std::string("box\0", 4) + triangle_mesh);
  return chunk(0x4D4D, chunk(2, std::string("\3\0\0\0", 4)) + chunk(0x3D3D, object));
}

}  // namespace intaglio::mesh
