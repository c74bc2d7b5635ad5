// Reads a recording with the format's reference library, checks every checksum, and
// compares every message with the lines of `intaglio recording export`. Prints what it
// read; ends with 1 at the first difference.
//   node compare_recording.mjs FILE EXPORT.jsonl
import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import { readFileSync } from "node:fs";

const [file, exported] = process.argv.slice(2);
const bytes = readFileSync(file);
const decompressHandlers = {
  zstd: (packed, size) => decompress(packed, new Uint8Array(Number(size))),
};

function fail(text) {
  console.log(text);
  process.exit(1);
}

// The stream reader checks the checksums of chunks, attachments and the data section.
const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
stream.append(bytes);
let streamed = 0;
for (let record; (record = stream.nextRecord()); ) {
  if (record.type === "Message") ++streamed;
}
if (!stream.done()) fail("the file does not end as it should");

const reader = await McapIndexedReader.Initialize({
  readable: {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
  },
  decompressHandlers,
});

const types = new Map();
function typeOf(channel) {
  if (!types.has(channel.schemaId)) {
    const schema = reader.schemasById.get(channel.schemaId);
    if (schema.encoding !== "omgidl") fail(`${channel.topic}: schema ${schema.encoding}`);
    const definitions = parseIDL(new TextDecoder().decode(schema.data));
    const names = new Map();
    for (const definition of definitions) {
      for (const field of definition.definitions ?? []) {
        if (field.isConstant) names.set(field.name, field.value);
      }
    }
    types.set(channel.schemaId, { reader: new MessageReader(schema.name, definitions), names });
  }
  return types.get(channel.schemaId);
}

function compare(ours, theirs, names, path) {
  if (typeof theirs === "bigint") theirs = Number(theirs);
  if (typeof ours === "string" && typeof theirs === "number") ours = names.get(ours);
  if (typeof theirs === "object" && theirs !== null) {
    const keys = Object.keys(theirs);
    if (Object.keys(ours).length !== keys.length) fail(`${path}: other members`);
    for (const key of keys) compare(ours[key], theirs[key], names, `${path}.${key}`);
  } else if (ours !== theirs) {
    fail(`${path}: ${ours} is ${theirs} to the reference library`);
  }
}

const lines = readFileSync(exported, "utf8").trimEnd().split("\n").map((line) => JSON.parse(line));
const queues = new Map();
for (const line of lines) {
  const key = `${line.topic} ${line.partition} ${line.sequence}`;
  queues.set(key, line);
}
let read = 0;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const key = `${channel.topic} ${channel.metadata.get("partition") ?? ""} ${message.sequence}`;
  const ours = queues.get(key);
  if (ours === undefined) fail(`${key} is not among the exported lines`);
  if (ours.log_time_ns !== Number(message.logTime)) fail(`${key}: other log time`);
  const { reader: decoder, names } = typeOf(channel);
  compare(ours.value, decoder.readMessage(message.data), names, key);
  ++read;
}
const attachments = [];
for await (const attachment of reader.readAttachments()) attachments.push(attachment.name);
if (read !== lines.length || read !== streamed) fail(`${read} of ${lines.length} messages`);
console.log(`${read} messages, ${types.size} types, ${attachments.length} attachments agree`);
