#include "services/console/photo_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "engrave/io/whole_file.h"
#include "tests/engrave/image/pictures.h"
#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const reading::PictureProcess kReader{fs::path(INTAGLIO_BIN_DIR) /
                                      "intaglio-picture-reader"};

std::string Photo(int width = 40) { return image::EncodePng(width, 30, image::Colours); }

/// In the place of the reader.
reading::PictureProcess Script(const fs::path& folder, const std::string& what) {
  const fs::path file = folder / "reader";
  std::ofstream(file) << "#!/bin/sh\n" << what << "\n";
  fs::permissions(file, fs::perms::owner_all);
  return {file, std::chrono::seconds(1)};
}

void ExpectRefused(const Status& saved, ErrorCode code, const std::string& why,
                   const fs::path& folder) {
  ASSERT_FALSE(saved);
  EXPECT_EQ(saved.error().code, code) << saved.error().message;
  EXPECT_THAT(saved.error().message, HasSubstr("block.png"));
  EXPECT_THAT(saved.error().message, HasSubstr(why));
  EXPECT_FALSE(fs::exists(folder / "block_photo.png"));
}

TEST(Photo, IsKeptAsItWasSent) {
  const fs::path folder = test::FreshFolder();
  const auto saved = SavePhoto(folder, "block.png", Photo(), kReader);
  ASSERT_TRUE(saved) << saved.error().message;
  EXPECT_EQ(io::ReadWholeFile(folder / "block_photo.png", kMaxPhotoBytes), Photo());
}

TEST(Photo, ThatIsDamagedOrTooLargeIsRefused) {
  const fs::path folder = test::FreshFolder();
  ExpectRefused(SavePhoto(folder, "block.png", Photo().substr(0, 60), kReader),
                ErrorCode::kUnreadable, "", folder);
  ExpectRefused(SavePhoto(folder, "block.png", Photo(400'001), kReader),
                ErrorCode::kTooLarge, "pixels", folder);
  ExpectRefused(SavePhoto(folder, "block.png", "GIF89a", kReader),
                ErrorCode::kUnsupported, "no JPEG or PNG file", folder);
}

// It costs the process that decodes it: this one goes on.
TEST(Photo, ThatCrashesItsDecoderIsRefused) {
  const fs::path folder = test::FreshFolder();
  ExpectRefused(SavePhoto(folder, "block.png", Photo(), Script(folder, "kill -SEGV $$")),
                ErrorCode::kUnreadable,
                "it crashed the reader of pictures (Segmentation fault)", folder);
  ExpectRefused(SavePhoto(folder, "block.png", Photo(), Script(folder, "exit 3")),
                ErrorCode::kUnreadable, "(exit code 3)", folder);
}

TEST(Photo, ThatIsDecodedForEverIsRefused) {
  const fs::path folder = test::FreshFolder();
  ExpectRefused(
      SavePhoto(folder, "block.png", Photo(), Script(folder, "while :; do :; done")),
      ErrorCode::kTooLarge, "more than 1 s of processor time", folder);
}

TEST(Photo, WithoutTheDecodersProgramTheRemedyIsReported) {
  const fs::path folder = test::FreshFolder();
  ExpectRefused(SavePhoto(folder, "block.png", Photo(), {"/no/such/program"}),
                ErrorCode::kNotFound, "/no/such/program cannot be started", folder);
}

}  // namespace
}  // namespace intaglio::console
