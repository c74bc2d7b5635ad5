#include "services/job/models/mesh_answer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace intaglio::mesh_reader {
namespace {

constexpr std::array<char, 8> kMagic = {'I', 'M', 'E', 'S', 'H', '1', '\0', '\0'};
constexpr auto kLastCode = static_cast<std::uint64_t>(ErrorCode::kCancelled);

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint64_t error = 0, first_size = 0, second_size = 0;
};
static_assert(sizeof(Header) == 32 && sizeof(Vec3) == 24 && sizeof(mesh::Triangle) == 12);

/// The header and two arrays.
std::vector<std::byte> Join(const Header& header, const void* first,
                            std::size_t first_bytes, const void* second,
                            std::size_t second_bytes) {
  std::vector<std::byte> bytes(sizeof header + first_bytes + second_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  if (first_bytes > 0) std::memcpy(bytes.data() + sizeof header, first, first_bytes);
  if (second_bytes > 0) {
    std::memcpy(bytes.data() + sizeof header + first_bytes, second, second_bytes);
  }
  return bytes;
}

/// Two arrays of these sizes, which may be any, are all of `room` bytes.
bool Fill(std::uint64_t first_size, std::size_t first_item, std::uint64_t second_size,
          std::size_t second_item, std::size_t room) {
  return first_size <= room / first_item && second_size <= room / second_item &&
         first_size * first_item + second_size * second_item == room;
}

std::optional<Answer> MeshOf(const Header& header, std::span<const std::byte> inside) {
  if (!Fill(header.first_size, sizeof(Vec3), header.second_size, sizeof(mesh::Triangle),
            inside.size())) {
    return std::nullopt;
  }
  mesh::TriangleMesh made;
  made.vertices.resize(header.first_size);
  made.triangles.resize(header.second_size);
  const std::size_t vertex_bytes = header.first_size * sizeof(Vec3);
  if (!made.vertices.empty()) {
    std::memcpy(static_cast<void*>(made.vertices.data()), inside.data(), vertex_bytes);
  }
  if (!made.triangles.empty()) {
    std::memcpy(made.triangles.data(), inside.data() + vertex_bytes,
                inside.size() - vertex_bytes);
  }
  const bool places = std::all_of(made.vertices.begin(), made.vertices.end(),
                                  [](const Vec3& vertex) { return vertex.allFinite(); });
  const bool corners = std::all_of(
      made.triangles.begin(), made.triangles.end(), [&](const mesh::Triangle& triangle) {
        return std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t corner) {
          return corner < made.vertices.size();
        });
      });
  if (!places || !corners) return std::nullopt;
  return Answer(std::move(made));
}

std::optional<Answer> ErrorOf(const Header& header, std::span<const std::byte> inside) {
  if (header.error > kLastCode + 1 ||
      !Fill(header.first_size, 1, header.second_size, 1, inside.size())) {
    return std::nullopt;
  }
  const std::string text(reinterpret_cast<const char*>(inside.data()), inside.size());
  return Fail(static_cast<ErrorCode>(header.error - 1), text.substr(0, header.first_size),
              text.substr(header.first_size));
}

}  // namespace

std::vector<std::byte> EncodeAnswer(const Answer& answer) {
  Header header;
  if (!answer) {
    const Error& error = answer.error();
    header.error = static_cast<std::uint64_t>(error.code) + 1;
    header.first_size = error.message.size();
    header.second_size = error.value.size();
    return Join(header, error.message.data(), error.message.size(), error.value.data(),
                error.value.size());
  }
  header.first_size = answer->vertices.size();
  header.second_size = answer->triangles.size();
  return Join(header, answer->vertices.data(), answer->vertices.size() * sizeof(Vec3),
              answer->triangles.data(),
              answer->triangles.size() * sizeof(mesh::Triangle));
}

std::optional<Answer> ParseAnswer(std::span<const std::byte> bytes) {
  Header header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != kMagic) return std::nullopt;
  const auto inside = bytes.subspan(sizeof header);
  return header.error == 0 ? MeshOf(header, inside) : ErrorOf(header, inside);
}

}  // namespace intaglio::mesh_reader
