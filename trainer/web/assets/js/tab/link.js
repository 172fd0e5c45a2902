// The page's line to the boat inside it, in place of one to a session elsewhere.
import { Card } from "../tab/card.js";
import { FirstLever } from "../tab/first-lever.js";

/**
 * @typedef {import("../protocol/link.js").Answer} Answer
 * @typedef {import("../protocol/line.js").Sentence} Sentence
 */

/** Sends orders to the worker, and brings answers and sentences: events `open`, `lost`, `sentence`. */
export class Link extends EventTarget {
  constructor() {
    super();
    this.alone = true;
    this.there = false;
    this.tries = 0;
    this.why = "";
    this.tag = 0;
    /** @type {Map<string, (answer: Answer) => void>} */
    this.asked = new Map();
    /** @type {Worker | null} */
    this.worker = null;
    /** @type {Card | null} of a recording */
    this.card = null;
    this.hasWay = false; // the reference crew's run came with it
  }

  /** Begins the worker, whose source and boat lie in the page. */
  open() {
    if (this.worker) return;
    const source = new Blob([textOf("worker")], { type: "text/javascript" });
    this.worker = new Worker(URL.createObjectURL(source));
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => this.lose(event.message || "the boat could not be started");
    this.begin().catch((error) => this.lose(String(error)));
    self.frameElement?.ownerDocument.addEventListener("click", ({ target }) => void this.play(target));
  }

  /** Flies on from where a link of the debrief around this frame leads. @param {EventTarget | null} target */
  async play(target) {
    const link = /** @type {HTMLElement | null} */ (target)?.closest?.("[data-orders]");
    for (const words of /** @type {HTMLElement} */ (link)?.dataset.orders?.split("; ") ?? []) {
      if (!(await this.order(words)).ok) return;
    }
  }

  async begin() {
    const boat = JSON.parse(new TextDecoder().decode(await unpacked("boat")));
    if (boat.first_lever) new FirstLever(this, boat.first_lever);
    this.worker?.postMessage({ module: await unpacked("core"), boat });
  }

  /** @param {{ sentences?: Sentence[], ready?: boolean, tag?: string, answer?: Answer }} message */
  hear({ sentences = [], ready, tag, answer }) {
    if (ready) {
      this.there = true;
      this.dispatchEvent(new Event("open"));
    }
    for (const detail of sentences) {
      this.dispatchEvent(new CustomEvent("sentence", { detail }));
      if (detail.kind === "TRF") this.attend(detail.fields);
    }
    if (tag && answer) {
      this.asked.get(tag)?.(answer);
      this.asked.delete(tag);
    }
  }

  /** Shows what a recording is sent for, and how a try went; a debrief tells it around its frame. @param {string[]} fact */
  attend([, , what, subject]) {
    if (what === "exercise" && subject === "way=yes") this.hasWay = true;
    if (what === "task" && self === top) (this.card ??= new Card(this)).offer(subject);
    if (what === "result") this.card?.tell(subject);
  }

  /** @param {string} words @returns {Promise<Answer>} */
  order(words) {
    if (!this.there) return Promise.resolve({ ok: false, text: this.why || "not sent: no boat yet", lines: [] });
    this.tag += 1;
    const tag = String(this.tag);
    this.worker?.postMessage({ tag, words });
    return new Promise((settle) => {
      this.asked.set(tag, settle);
    });
  }

  /** @param {string} why */
  lose(why) {
    this.there = false;
    this.why = why;
    this.tries = 2;
    this.dispatchEvent(new Event("lost"));
  }

  settle() {
    this.tries = 0;
  }

  redial() {}

  close() {
    this.worker?.terminate();
  }
}

/** @param {string} id of a block of data in the page */
function textOf(id) {
  return document.getElementById(`tab-${id}`)?.textContent ?? "";
}

/** Returns the bytes of a packed block of data. @param {string} id */
async function unpacked(id) {
  const bytes = Uint8Array.from(atob(textOf(id)), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
