// Foxglove's own client receives every channel, and its own readers of ROS 2 messages decode each
// message by the schema that came with it.

import assert from "node:assert/strict";
import foxglove from "@foxglove/ws-protocol";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { WebSocket } from "ws";
import { chain, holds, page } from "./processes.mjs";

const { FoxgloveClient } = foxglove;
const [, , lariat] = process.argv;
const rig = await chain(lariat);
const view = await page(lariat);

const client = new FoxgloveClient({ ws: new WebSocket(view.found[0].replace("http", "ws"), [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const channels = new Map();
const messages = new Map();
client.on("error", (error) => assert.fail(error));
client.on("advertise", (advertised) => {
  for (const channel of advertised) channels.set(client.subscribe(channel.id), channel);
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const channel = channels.get(subscriptionId);
  const message = channel.encoding === "json"
    ? JSON.parse(new TextDecoder().decode(data))
    : new MessageReader(parse(channel.schema, { ros2: true })).readMessage(data);
  assert.ok(Math.abs(Number(timestamp) / 1e6 - Date.now()) < 60_000, `${channel.topic} is of ${timestamp}`);
  messages.set(channel.topic, message);
});
await holds("every channel has come", () => channels.size > 0 && messages.size === channels.size);
assert.equal(messages.get("/cell/image").width, 640);
assert.equal(messages.get("/cell/image").data.length, 640 * 480 * 3);
assert.deepEqual([...messages.get("/cell/image/compressed").data.slice(0, 2)], [0xff, 0xd8]);
const [rope] = messages.get("/cell/descriptors").curves;
assert.ok(rope.control_points.length > 3 && rope.length > 100, "a rope's descriptor");
assert.ok(messages.get("/cell/annotations/ropes").points[0].points.length > 10, "a rope's drawing");
assert.ok(messages.get("/cell/latency").total_ms > 0);
client.close();
console.log(`Foxglove's client has ${[...messages.keys()].sort().join(" ")}`);
await view.end();
await rig.end();
