// A boat of a page, flown by node: what is asked for comes as JSON, what came of it goes out as JSON.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [scripts, module] = process.argv.slice(2);
const { Desk } = await import(pathToFileURL(`${scripts}/desk.js`).href);
const { boat, deeds } = JSON.parse(readFileSync(0, "utf8"));
const clock = { time: 0, waits: [], now: () => clock.time };
clock.later = (call, wait) => clock.waits.push([clock.time + wait, call]);
const sent = [];
const desk = await Desk.open(readFileSync(module), boat, (sentences) => sent.push(...sentences), clock);
const { core } = desk;

const digest = () => {
  const bytes = new Uint8Array(core.state.buffer, core.state.byteOffset, core.state.byteLength);
  return createHash("sha256").update(bytes).digest("hex");
};
/** What may be done: each returns what is told of it. */
const DEEDS = {
  order: (words) => desk.answer(words),
  fly: (ticks) => {
    for (let left = ticks; left > 0; left -= 1) desk.tick();
    return core.ticks;
  },
  write: (writes) => {
    for (const [place, value] of writes) core.state[place] = value;
    return core.ticks;
  },
  set: (numbers) => core.state.set(numbers),
  digest,
  state: () => [...core.state],
  values: (channel) => desk.readings.values(channel),
  sent: () => sent.splice(0),
  visit: (tick) => {
    desk.flight.visit(desk.flight.present, tick);
    return digest();
  },
  // the machine's time goes on by so many milliseconds; timers work when they are due, or after a sleep
  pass: ([span, asleep]) => {
    const end = clock.time + span;
    if (asleep) clock.time = end;
    while (clock.waits.some(([at]) => at <= end)) {
      clock.waits.sort((a, b) => a[0] - b[0]);
      const [at, call] = clock.waits.shift();
      clock.time = Math.max(clock.time, at);
      call();
    }
    clock.time = end;
    return core.ticks;
  },
  time: () => performance.now(),
};
process.stdout.write(JSON.stringify(deeds.map(([deed, argument]) => DEEDS[deed](argument) ?? null)));
