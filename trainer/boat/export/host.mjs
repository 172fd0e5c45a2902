// A host for node: the boat flies on its own orders, and the SHA-256 of its last state is printed.
//
//     node host.mjs 7200
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";

const folder = new URL(".", import.meta.url);
const boat = JSON.parse(readFileSync(new URL("boat.json", folder), "utf8"));
const { instance } = await WebAssembly.instantiate(readFileSync(new URL("core.wasm", folder)));
const core = instance.exports;
const rooms = ["vessel", "compact", "scheme", "state", "scratch"];
const places = rooms.map((room) => core[`trainer_${room}`].value);
const bytes = new Uint8Array(core.memory.buffer);
for (const [room, packed] of Object.entries(boat.records)) {
  bytes.set(Buffer.from(packed, "base64"), core[`trainer_${room}`].value);
}
const state = new Float64Array(core.memory.buffer, core.trainer_state.value, boat.state_doubles);

state[boat.places.ordered_depth] += 10; // an order is a number written before a tick
for (let tick = Number(process.argv[2] ?? 120); tick > 0; tick -= 1) {
  const status = core.trainer_tick(...places);
  if (status) throw new Error(`tick ${state[boat.places.tick]} failed with status ${status}`);
}
const [depth, seconds] = [state[boat.places.z], state[boat.places.tick] * boat.step_s];
console.log(`${seconds} s: ${depth.toFixed(2)} m deep`);
console.log(createHash("sha256").update(new Uint8Array(state.buffer, state.byteOffset, state.byteLength)).digest("hex"));
