// The scene of a recorded job, read as a viewer does: by the schemas in the file.

#include "services/scene/scene_file.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/util/json_util.h>

#include <filesystem>
#include <memory>

#include "services/platform/recording/message_decoder.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/services/scene/packed_cloud.h"
#include "tests/test_folder.h"

namespace intaglio::scene {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;
using recording::McapReader;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Key;

const fs::path kRecordings = INTAGLIO_SOURCE_DIR "/tests/data/recordings";

struct Drawn {
  std::string type, json;
  recording::Bytes payload;
  std::uint64_t time_ns = 0;
};

/// The messages of each topic, by a parser that has nothing but the file.
std::map<std::string, std::vector<Drawn>> DrawnIn(const McapReader& reader) {
  std::map<std::string, std::vector<Drawn>> drawn;
  for (const auto& message : recording::MessagesOf(reader)) {
    const auto& channel = reader.contents().channels.at(message.channel_id);
    EXPECT_EQ(channel.message_encoding, "protobuf");
    const recording::Schema& schema = *reader.SchemaOf(channel);
    EXPECT_EQ(schema.encoding, "protobuf");
    pb::FileDescriptorSet files;
    EXPECT_TRUE(files.ParseFromString(schema.text));
    pb::DescriptorPool pool;
    for (const auto& file : files.file())
      EXPECT_NE(pool.BuildFile(file), nullptr) << "each behind its imports";
    pb::DynamicMessageFactory factory;
    const auto* type = pool.FindMessageTypeByName(schema.name);
    if (type == nullptr) {
      ADD_FAILURE() << schema.name;
      continue;
    }
    const std::unique_ptr<pb::Message> value(factory.GetPrototype(type)->New());
    EXPECT_TRUE(value->ParseFromArray(message.payload.data(),
                                      static_cast<int>(message.payload.size())));
    std::string json;
    EXPECT_TRUE(pb::util::MessageToJsonString(*value, &json).ok());
    drawn[channel.topic].push_back(
        {schema.name, json, message.payload, message.log_time_ns});
  }
  return drawn;
}

std::vector<CloudPoint> PointsOf(const Drawn& drawn) {
  foxglove::PointCloud cloud;
  EXPECT_TRUE(
      cloud.ParseFromArray(drawn.payload.data(), static_cast<int>(drawn.payload.size())));
  return PointsOfCloud(cloud);
}

/// Path and pulses of the recording itself.
struct Truth {
  PointList path_mm;
  std::map<std::uint64_t, std::uint64_t> tick_of_point;
};

Truth TruthOf(const McapReader& reader) {
  Truth truth;
  recording::MessageDecoder decoder(reader);
  for (const auto& message : recording::MessagesOf(reader)) {
    const std::string& topic = reader.contents().channels.at(message.channel_id).topic;
    if (topic != "PathBatch" && topic != "PulseEventBatch") continue;
    const auto value = decoder.Decode(message.view()).value();
    const auto reals = [&](const char* name) {
      return *value.Find(name)->As<std::vector<double>>();
    };
    const auto numbers = [&](const char* name) {
      return *value.Find(name)->As<std::vector<std::uint64_t>>();
    };
    if (topic == "PathBatch") {
      for (std::size_t i = 0; i < reals("x_mm").size(); ++i)
        truth.path_mm.emplace_back(reals("x_mm")[i], reals("y_mm")[i], reals("z_mm")[i]);
    } else {
      for (std::size_t i = 0; i < numbers("tick").size(); ++i)
        truth.tick_of_point[numbers("point")[i]] = numbers("tick")[i];
    }
  }
  return truth;
}

class SceneFile : public ::testing::Test {
 protected:
  SceneFile() : file_(test::FreshFolder() / "scene.mcap") {}
  std::map<std::string, std::vector<Drawn>> SceneOf(const McapReader& reader) const {
    const auto written = WriteScene(reader, {}, file_);
    EXPECT_TRUE(written) << written.error().message;
    return DrawnIn(McapReader::Open(file_).value());
  }
  fs::path file_;
};

TEST_F(SceneFile, HasThePlanAndWhatBecameOfIt) {
  const auto reader = McapReader::Open(kRecordings / "pyramid.mcap").value();
  const Truth truth = TruthOf(reader);
  ASSERT_EQ(truth.path_mm.size(), 272u);
  ASSERT_EQ(truth.tick_of_point.size(), 272u);
  const auto scene = SceneOf(reader);
  EXPECT_THAT(scene,
              ElementsAre(Key("/job-1/beam"), Key("/job-1/block"), Key("/job-1/frame"),
                          Key("/job-1/made"), Key("/job-1/new"), Key("/job-1/plan")));
  const auto plan = PointsOf(scene.at("/job-1/plan").front());
  ASSERT_EQ(plan.size(), truth.path_mm.size());
  for (const CloudPoint& point : plan)
    EXPECT_LT((point.place_mm - truth.path_mm[point.order]).norm(), 1e-5);
  const auto made = PointsOf(scene.at("/job-1/made").back());
  ASSERT_EQ(made.size(), truth.tick_of_point.size());
  for (const CloudPoint& point : made) {
    EXPECT_EQ(point.tick, truth.tick_of_point.at(point.order));
    EXPECT_LT((point.place_mm - truth.path_mm[point.order]).norm(), 1e-5);
  }
  EXPECT_TRUE(PointsOf(scene.at("/job-1/plan").back()).empty()) << "none is to come";
  std::size_t reported = 0;
  for (const Drawn& drawn : scene.at("/job-1/new")) reported += PointsOf(drawn).size();
  EXPECT_EQ(reported, 272u);
  EXPECT_EQ(scene.at("/job-1/new").size(), 4u) << "one a report";
}

TEST_F(SceneFile, HasBlockFrameAndBeam) {
  const auto reader = McapReader::Open(kRecordings / "pyramid.mcap").value();
  const auto scene = SceneOf(reader);
  EXPECT_THAT(scene.at("/job-1/frame").front().json,
              ::testing::AllOf(HasSubstr("\"parentFrameId\":\"world\""),
                               HasSubstr("\"childFrameId\":\"job-1\"")));
  const std::string block = scene.at("/job-1/block").front().json;
  EXPECT_THAT(block, HasSubstr("\"size\":{\"x\":30,\"y\":30,\"z\":20}"));
  // The job ended at its last point: the axes are there, and the focus with them.
  const auto last = PointsOf(scene.at("/job-1/made").back());
  const Vec3 end_mm =
      std::max_element(last.begin(), last.end(), [](const auto& a, const auto& b) {
        return a.tick < b.tick;
      })->place_mm;
  foxglove::SceneUpdate update;
  const Drawn& beam = scene.at("/job-1/beam").back();
  ASSERT_TRUE(
      update.ParseFromArray(beam.payload.data(), static_cast<int>(beam.payload.size())));
  const auto& focus = update.entities(0).spheres(0).pose().position();
  EXPECT_LT((Vec3(focus.x(), focus.y(), focus.z()) - end_mm).norm(), 2.0);
}

TEST_F(SceneFile, OfARecordingWithoutPointsThereIsNone) {
  const auto reader = McapReader::Open(kRecordings / "pyramid.mcap").value();
  const auto written = WriteScene(reader, {.to_ns = 1}, file_);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kMissing);
  EXPECT_THAT(written.error().message, HasSubstr("no points"));
  EXPECT_FALSE(fs::exists(file_));
  EXPECT_FALSE(fs::exists(file_.string() + ".part"));
}

TEST_F(SceneFile, TheRecordingItselfIsNotOverwritten) {
  fs::copy_file(kRecordings / "pyramid.mcap", file_);
  const auto before = fs::file_size(file_);
  const auto written = WriteScene(McapReader::Open(file_).value(), {}, file_);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, HasSubstr("is an input"));
  EXPECT_EQ(fs::file_size(file_), before);
}

}  // namespace
}  // namespace intaglio::scene
