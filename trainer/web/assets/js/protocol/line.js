// Sentences of the line protocol: words framed with a checksum, both ways (docs/stations.md).

/**
 * A sentence from the session with a right checksum.
 * @typedef {{ kind: string, tag: string, fields: string[] }} Sentence
 */

const FRAME = /^\$([^$*]*)\*([0-9A-Fa-f]{2})$/;
const TAG = /^[0-9]{1,6}$/;
/** How many commas divide the fields of each kind; after them they belong to the text. */
const COMMAS = { TRA: 1, TRN: Infinity, TRS: Infinity, TRE: 3, TRF: 3 };

/**
 * Returns the exclusive or of the characters, in two hexadecimal digits.
 * @param {string} body
 */
export function checksum(body) {
  let sum = 0;
  for (let at = 0; at < body.length; at += 1) sum ^= body.charCodeAt(at);
  return sum.toString(16).toUpperCase().padStart(2, "0");
}

/**
 * Returns an order as a program sends it.
 * @param {string} words
 * @param {string} tag
 */
export function orderSentence(words, tag) {
  const body = `TRO,${tag},${words}`;
  return `$${body}*${checksum(body)}`;
}

/**
 * Returns the sentence on a line, null when it is damaged or none that is known.
 * @param {string} line
 * @returns {Sentence | null}
 */
export function read(line) {
  const found = FRAME.exec(line);
  if (!found || checksum(found[1]) !== found[2].toUpperCase()) return null;
  const [kind, content] = divide(found[1], 1);
  if (!(kind in COMMAS) || content === undefined) return null;
  const commas = COMMAS[/** @type {keyof typeof COMMAS} */ (kind)];
  const [first, rest] = divide(content, 1);
  if (kind === "TRA" && TAG.test(first) && rest !== undefined) {
    return { kind, tag: first, fields: divide(rest, commas) };
  }
  return { kind, tag: "", fields: divide(content, commas) };
}

/**
 * Returns the parts of a text between its first commas.
 * @param {string} text
 * @param {number} most commas
 */
function divide(text, most) {
  const parts = text.split(",");
  if (parts.length <= most + 1) return parts;
  return [...parts.slice(0, most), parts.slice(most).join(",")];
}

/** Returns the first character that no order can hold, "" where there is none. @param {string} words */
export function unsendable(words) {
  return /[^ -~]|[$*]/u.exec(words)?.[0] ?? "";
}
