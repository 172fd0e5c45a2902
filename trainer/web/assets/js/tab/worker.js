// The worker: the core, at its own pace, away from the page.
import { Desk } from "./desk.js";

/**
 * @typedef {{ module: Uint8Array<ArrayBuffer>, boat: import("./desk.js").Boat } |
 *   { tag: string, words: string }} Message
 */

const clock = {
  now: () => performance.now(),
  later: (/** @type {() => void} */ call, /** @type {number} */ wait) => void setTimeout(call, wait),
};
/** @type {Desk | null} */
let desk = null;

/** @param {MessageEvent<Message>} event */
onmessage = async ({ data }) => {
  if ("module" in data) {
    desk = await Desk.open(data.module, data.boat, (sentences) => postMessage({ sentences }), clock);
    if (!data.boat.recording) desk.pacer.run();
    postMessage({ ready: true });
  } else if (desk) {
    const answer = desk.answer(data.words);
    postMessage({ tag: data.tag, answer });
  }
};
