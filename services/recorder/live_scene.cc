#include "services/recorder/live_scene.h"

#include <span>
#include <utility>

#include "services/platform/recording/cdr_value.h"
#include "services/scene/message_schema.h"

namespace intaglio::recorder {

LiveScene::LiveScene()
    : maker_(std::make_unique<scene::SceneMaker>(
          [this](const std::string& topic, const google::protobuf::Message& message,
                 std::uint64_t time_ns) -> Status {
            RecordingSeries::Derived& of = derived_[topic];
            if (of.topic.empty()) {
              const auto& type = *message.GetDescriptor();
              of = {scene::TopicInFile(topic), type.full_name(), scene::kProtobuf,
                    scene::SchemaOf(type)};
            }
            const std::string bytes = message.SerializeAsString();
            series_->Write(of, time_ns, std::as_bytes(std::span(bytes)));
            return {};
          })) {}

void LiveScene::Add(const recording::Attachment& attachment) {
  if (const auto job = scene::JobOf(attachment)) maker_->AddJob(*job);
}

void LiveScene::Add(const Source& source, recording::ByteView payload,
                    std::uint64_t time_ns, RecordingSeries& series) {
  if (!scene::SceneMaker::Draws(source.topic)) return;
  auto types = types_.find(source.type);
  if (types == types_.end())
    types = types_.emplace(source.type, recording::ParseIdl(source.idl)).first;
  if (!types->second) return;
  const auto value = recording::DecodeCdr(*types->second, source.type, payload);
  if (!value) return;
  series_ = &series;
  if (std::exchange(file_number_, series.file_number()) != series.file_number())
    maker_->BeginAnew();
  (void)maker_->Add(source.topic, source.cell, *value, time_ns);
}

void LiveScene::Finish(RecordingSeries& series) {
  series_ = &series;
  (void)maker_->Finish();
}

}  // namespace intaglio::recorder
