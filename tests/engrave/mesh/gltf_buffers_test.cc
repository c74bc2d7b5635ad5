#include "engrave/mesh/files/gltf_buffers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::mesh {
namespace {

using ::testing::HasSubstr;

std::string GltfOf(const std::string& uri) {
  return R"({"extras":{"buffers":[{"uri":"no"}]},"images":[{"uri":"wood.png"}],)"
         R"("buffers":[{"uri":"data:,AA"},{"byteLength":3 , "uri" : ")" +
         uri + R"("}],"meshes":[{"uri":"no"}]})";
}

TEST(GltfBuffers, AreThoseOfTheBuffersAlone) {
  const std::string gltf = GltfOf("a.bin");
  const auto files = BufferFilesOf(gltf);
  ASSERT_TRUE(files) << files.error().message;
  ASSERT_EQ(files->size(), 1u);
  EXPECT_EQ(gltf.substr(files->front().begin, files->front().end - files->front().begin),
            "\"a.bin\"");
}

TEST(GltfBuffers, ArePathsBelowTheFolder) {
  const std::pair<const char*, const char*> read[] = {
      {"a.bin", "a.bin"},           {"bin/a.bin", "bin/a.bin"},
      {"bin\\/a.bin", "bin/a.bin"}, {"my%20model%3a1.bin", "my model:1.bin"},
      {"..a.bin", "..a.bin"},       {"./a.bin", "./a.bin"}};
  for (const auto& [uri, path] : read) {
    const auto files = BufferFilesOf(GltfOf(uri));
    ASSERT_TRUE(files && files->size() == 1) << uri;
    EXPECT_EQ(files->front().path, path);
  }
  for (const char* uri :
       {"", "/etc/passwd", "../a.bin", "b/../../a.bin", "%2e%2e/a.bin", "%2Fetc/passwd",
        "b/..", "http://a/b", "file:a", "C:a", "..\\\\a.bin", "a%00.bin", "%5ca", "a%2",
        "a%zz", "a\\u002fb", "folder/"}) {
    const auto files = BufferFilesOf(GltfOf(uri));
    ASSERT_FALSE(files) << uri;
    EXPECT_EQ(files.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(files.error().message, HasSubstr("no file in the folder of the model"));
  }
}

TEST(GltfBuffers, TextThatIsNoJsonHasNone) {
  for (const char* text : {"", "{", "]]]]", "{\"buffers", "{\"buffers\":[{\"uri\":\"",
                           "\\", "{\"buffers\":[{\"uri\":\"a\\"}) {
    const auto files = BufferFilesOf(text);
    ASSERT_TRUE(files) << text;
    EXPECT_TRUE(files->empty()) << text;
  }
}

}  // namespace
}  // namespace intaglio::mesh
