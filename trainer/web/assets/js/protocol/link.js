// The page's line to its session. It is dialled again for ever when it is lost.
import { orderSentence, read, unsendable } from "./line.js";
import { say } from "../words.js";

const WAITS = [0.5, 1, 2, 5]; // [s] until a lost line is dialled again; the last stays
const NO_SESSION = 4001;
const OLDER_PAGE = 4002;
const REFUSED = 4003;
const SILENCE = 10; // [s] after which an order is not answered any more

/**
 * @typedef {import("./line.js").Sentence} Sentence
 * @typedef {{ ok: boolean, text: string, lines: string[] }} Answer
 * @typedef {{ words: string, lines: string[], settle: (answer: Answer) => void }} Asked
 */

/** Says why a character is refused, as the session does. @param {string} sign */
function signRefused(sign) {
  const code = (sign.codePointAt(0) ?? 0).toString(16).toUpperCase().padStart(4, "0");
  return say("{0} cannot be sent; type plain letters", `"${sign}" (U+${code})`);
}

/** Sends orders and brings answers and sentences: events `open`, `lost`, `older`, `sentence`. */
export class Link extends EventTarget {
  /** @param {string} version of the page @param {string} [at] where its session's pages are */
  constructor(version, at = "./") {
    super();
    this.version = version;
    this.at = at;
    this.alone = false; // others are aboard, and an instructor's rules hold
    this.tries = 0;
    this.why = "";
    this.stopped = false;
    /** @type {WebSocket | null} */
    this.socket = null;
    /** @type {Map<string, Asked>} */
    this.asked = new Map();
    this.tag = 0;
    this.timer = 0; // of the next dial
  }

  /** Dials, now and after every loss. */
  open() {
    clearTimeout(this.timer);
    if (this.stopped) return;
    this.tries += 1;
    const address = new URL(`${this.at}line?version=${this.version}`, location.href);
    address.protocol = address.protocol.replace("http", "ws"); // and https becomes wss
    const socket = new WebSocket(address);
    this.socket = socket;
    socket.onopen = () => this.dispatchEvent(new Event("open"));
    socket.onmessage = (event) => String(event.data).split("\n").forEach((line) => this.hear(line));
    socket.onclose = (event) => this.lose(event.code, event.reason);
  }

  /** Whether there is a line now. */
  get there() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /**
   * Sends an order; the promise settles with its answer. A lost line answers no.
   * @param {string} words
   * @returns {Promise<Answer>}
   */
  order(words) {
    if (!this.there) return Promise.resolve({ ok: false, text: say("not sent: no line"), lines: [] });
    const sign = unsendable(words);
    if (sign) return Promise.resolve({ ok: false, text: signRefused(sign), lines: [] });
    this.tag = (this.tag % 999_999) + 1;
    const tag = String(this.tag);
    this.socket?.send(orderSentence(words.trim(), tag));
    return new Promise((settle) => {
      this.asked.set(tag, { words, lines: [], settle });
      setTimeout(() => this.answer(tag, false, say("no answer")), SILENCE * 1000);
    });
  }

  /** Goes away for good. */
  close() {
    this.stopped = true;
    this.socket?.close();
  }

  /** @param {string} line */
  hear(line) {
    const sentence = read(line);
    if (!sentence) return;
    if (sentence.kind !== "TRA") {
      this.dispatchEvent(new CustomEvent("sentence", { detail: sentence }));
      return;
    }
    const [what, text] = sentence.fields;
    const asked = this.asked.get(sentence.tag);
    if (what === "say") asked?.lines.push(text);
    else this.answer(sentence.tag, what === "ok", text);
  }

  /**
   * @param {string} tag
   * @param {boolean} ok
   * @param {string} text
   */
  answer(tag, ok, text) {
    const asked = this.asked.get(tag);
    this.asked.delete(tag);
    asked?.settle({ ok, text, lines: asked.lines });
  }

  /**
   * @param {number} code
   * @param {string} reason
   */
  lose(code, reason) {
    this.forget(say("the line is lost"));
    this.why = reason || (code === NO_SESSION ? say("no session") : say("the server does not answer"));
    if (code === OLDER_PAGE) this.stopped = true;
    this.dispatchEvent(new Event(code === OLDER_PAGE ? "older" : "lost"));
    const tried = Math.max(Math.min(this.tries, WAITS.length), 1); // none of a line that did well
    const wait = code === REFUSED ? WAITS.at(-1) : WAITS[tried - 1];
    this.timer = setTimeout(() => this.open(), (wait ?? 5) * 1000);
  }

  /** Dials at once, in place of the line that is there: the browser has another token now. */
  redial() {
    if (this.socket) this.socket.onclose = null;
    this.socket?.close();
    this.forget(say("the line is dialled anew"));
    this.open();
  }

  /** Answers no to all that waits for an answer. @param {string} why */
  forget(why) {
    for (const tag of [...this.asked.keys()]) this.answer(tag, false, why);
  }

  /** Says that the line does well: the next loss is dialled again soon. */
  settle() {
    this.tries = 0;
  }
}
